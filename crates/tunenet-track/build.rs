//! Says in one sentence what is missing, before the long build of the OpenCV bindings fails with a page of its own.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Whoever sets one of these points the bindings to an OpenCV of his own.
const OWN_OPENCV: [&str; 14] = [
    "OPENCV_LINK_LIBS",
    "OPENCV_LINK_PATHS",
    "OPENCV_INCLUDE_PATHS",
    "OPENCV_PACKAGE_NAME",
    "OPENCV_PKGCONFIG_NAME",
    "OPENCV_CMAKE_NAME",
    "OPENCV_CMAKE_BIN",
    "OPENCV_CMAKE_TOOLCHAIN_FILE",
    "OPENCV_VCPKG_NAME",
    "OPENCV_DISABLE_PROBES",
    "CMAKE_PREFIX_PATH",
    "OpenCV_DIR",
    "VCPKG_ROOT",
    "DOCS_RS",
];
/// And one of these, to a clang of his own.
const OWN_CLANG: [&str; 3] = ["LIBCLANG_PATH", "LLVM_CONFIG_PATH", "CLANG_PATH"];

/// Where systems keep libclang, besides `/usr/lib/llvm-*/lib`.
const LIBRARY_FOLDERS: [&str; 5] =
    ["/usr/lib", "/usr/lib64", "/usr/local/lib", "/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu"];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=PKG_CONFIG_PATH");
    for name in OWN_OPENCV.iter().chain(&OWN_CLANG) {
        println!("cargo::rerun-if-env-changed={name}");
    }
    // Elsewhere both are found in too many ways to judge; the bindings' own message has to do.
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("linux") {
        return;
    }
    if let Some(what) = missing() {
        println!(
            "cargo::error={what} is missing: run \"apt-get install libopencv-dev clang libclang-dev pkg-config\" \
             (Debian, Ubuntu), or build without video: --no-default-features"
        );
    }
}

/// The first thing that the bindings will not find.
fn missing() -> Option<&'static str> {
    if !set(&OWN_OPENCV) && !runs("pkg-config", &["--exists", "opencv4"]) {
        let headers = ["/usr/include/opencv4", "/usr/local/include/opencv4"].iter().any(|p| Path::new(p).is_dir());
        if !headers {
            return Some("OpenCV");
        }
        // The headers alone do not tell what to link: the bindings ask pkg-config or CMake.
        if !runs("cmake", &["--version"]) {
            return Some("pkg-config");
        }
    }
    if !set(&OWN_CLANG) {
        if !runs("clang", &["--version"]) {
            return Some("clang");
        }
        if !libclang() {
            return Some("libclang");
        }
    }
    None
}

fn set(names: &[&str]) -> bool {
    names.iter().any(|name| std::env::var_os(name).is_some())
}

fn runs(program: &str, arguments: &[&str]) -> bool {
    let run = Command::new(program).args(arguments).stdout(Stdio::null()).stderr(Stdio::null()).status();
    run.is_ok_and(|status| status.success())
}

fn libclang() -> bool {
    let entries = |folder: &Path| std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path());
    let versions = entries(Path::new("/usr/lib")).map(|p| p.join("lib"));
    let reported = Command::new("llvm-config").arg("--libdir").stderr(Stdio::null()).output();
    let reported = reported.ok().and_then(|o| String::from_utf8(o.stdout).ok()).map(|text| PathBuf::from(text.trim()));
    let library = |path: PathBuf| {
        let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
        // The C++ library comes with the compiler; the bindings load the C library. A link to nothing does not exist.
        (name.starts_with("libclang.so") || name.starts_with("libclang-") && name.contains(".so"))
            && !name.starts_with("libclang-cpp")
            && path.exists()
    };
    LIBRARY_FOLDERS
        .iter()
        .map(PathBuf::from)
        .chain(versions)
        .chain(reported)
        .any(|folder| entries(&folder).any(library))
}
