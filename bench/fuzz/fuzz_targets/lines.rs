#![no_main]

use libfuzzer_sys::fuzz_target;
use situ_bench_fuzz::checks;

fuzz_target!(|bytes: &[u8]| {
    checks::requests(bytes);
    checks::answers(bytes);
});
