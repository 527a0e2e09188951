// SPDX-License-Identifier: Apache-2.0
//! Compiles bn.c, the single-file version of libbn, with $CC (default: cc) and $AR (default: ar). $BN_AMALGAMATION
//! names the folder that contains bn.c and bn.h. If it is not set, scripts/amalgamate creates one, which needs Python
//! 3 and the checkout.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{exit, Command};

fn fail(message: &str) -> ! {
    eprintln!("libbn-sys: {message}");
    exit(1);
}

/// Runs a command whose program may include options, as in CC="ccache gcc".
fn run(program: &str, arguments: &[&str]) {
    let mut words = program.split_whitespace();
    let name = words.next().unwrap_or_else(|| fail("CC and AR must not be empty"));
    match Command::new(name).args(words).args(arguments).status() {
        Ok(status) if status.success() => {}
        Ok(status) => fail(&format!("{program} ended with {status}")),
        Err(error) => fail(&format!("cannot run {name}: {error}")),
    }
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap_or_else(|| fail("folders need names in UTF-8"))
}

fn amalgamation(here: &Path, out: &Path) -> PathBuf {
    if let Some(folder) = env::var_os("BN_AMALGAMATION") {
        let folder = PathBuf::from(folder);
        if !folder.join("bn.c").is_file() {
            fail(&format!("no bn.c in BN_AMALGAMATION={}", folder.display()));
        }
        return folder;
    }
    let root = here.join("../../..");
    let script = root.join("scripts/amalgamate");
    if !script.is_file() {
        let packaged = here.join("amalgamation"); // of a published crate
        if packaged.join("bn.c").is_file() {
            return packaged;
        }
        fail("no scripts/amalgamate three folders up; set BN_AMALGAMATION to a folder with bn.c and bn.h");
    }
    for watched in ["libbn/src", "libbn/include", "libbn/data", "scripts/amalgamate"] {
        println!("cargo:rerun-if-changed={}", root.join(watched).display());
    }
    let folder = out.join("amalgamation");
    let python = env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    run(&python, &[text(&script), "--output", text(&folder)]);
    folder
}

fn main() {
    let here = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("Cargo sets it"));
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("Cargo sets it"));
    if env::var("CARGO_CFG_TARGET_ENV").as_deref() == Ok("msvc") {
        fail("MSVC is untried; use a -gnu target");
    }
    if env::var("HOST") != env::var("TARGET") && env::var_os("CC").is_none() {
        fail("set CC and AR to the tools of the target");
    }
    for name in ["BN_AMALGAMATION", "PYTHON", "CC", "AR"] {
        println!("cargo:rerun-if-env-changed={name}");
    }
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=shim.c");

    let folder = amalgamation(&here, &out);
    println!("cargo:rerun-if-changed={}", folder.join("bn.c").display());
    let compiler = env::var("CC").unwrap_or_else(|_| "cc".into());
    let include = format!("-I{}", text(&folder));
    let mut objects = Vec::new();
    for source in [folder.join("bn.c"), here.join("shim.c")] {
        let object = out.join(source.with_extension("o").file_name().expect("a file"));
        // Results are bit-identical at every optimisation level.
        run(&compiler, &["-std=c11", "-O2", "-fPIC", &include, "-c", text(&source), "-o", text(&object)]);
        objects.push(object);
    }
    let library = out.join("libbn.a");
    let _ = std::fs::remove_file(&library); // ar would add to it
    let archiver = env::var("AR").unwrap_or_else(|_| "ar".into());
    run(&archiver, &["crs", text(&library), text(&objects[0]), text(&objects[1])]);
    println!("cargo:rustc-link-search=native={}", out.display());
    println!("cargo:rustc-link-lib=static=bn");
    if env::var_os("CARGO_CFG_UNIX").is_some() {
        println!("cargo:rustc-link-lib=m");
        println!("cargo:rustc-link-lib=pthread");
    }
}
