//! Tells the program what it was built of: the sources and the lock file, each as a hash, the revision and the
//! compiler. The manifests of ledgers and the baselines name them. The script runs again where a source changed; a
//! commit changes none.

use std::env;
use std::fs;
use std::path::Path;
use std::process::Command;

use sha2::{Digest, Sha256};

#[path = "src/program/checkout.rs"]
mod checkout;

fn main() {
    let root = Path::new("..");
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let version = Command::new(rustc).arg("--version").output();
    let version = version.ok().and_then(|output| String::from_utf8(output.stdout).ok());
    let lock = fs::read(root.join("Cargo.lock")).ok();
    tell("TOOLCHAIN", version.as_deref().map(str::trim));
    tell("TARGET", env::var("TARGET").ok().as_deref());
    tell("LOCK", lock.map(|text| checkout::hex(&Sha256::digest(text))).as_deref());
    tell("SOURCES", checkout::sources(root).as_deref());
    tell("REVISION", checkout::revision(root).as_deref());
    let watched = checkout::PARTS.iter().map(|part| root.join(part)).filter(|path| path.exists());
    watched.for_each(|path| println!("cargo:rerun-if-changed={}", path.display()));
}

fn tell(name: &str, value: Option<&str>) {
    println!("cargo:rustc-env=SITU_{name}={}", value.unwrap_or("unknown"));
}
