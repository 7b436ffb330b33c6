//! Tells the program which compiler made it. The baselines of update cost name it.

use std::env;
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let version = Command::new(rustc).arg("--version").output();
    let version = version.ok().and_then(|output| String::from_utf8(output.stdout).ok());
    println!("cargo:rustc-env=SITU_TOOLCHAIN={}", version.as_deref().map_or("unknown", str::trim));
    println!("cargo:rustc-env=SITU_TARGET={}", env::var("TARGET").unwrap_or_else(|_| "unknown".to_owned()));
}
