//! Gives the shared library a name for the loader.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let [os, major, minor] =
        ["CARGO_CFG_TARGET_OS", "CARGO_PKG_VERSION_MAJOR", "CARGO_PKG_VERSION_MINOR"].map(std::env::var);
    if os.as_deref() == Ok("linux")
        && let (Ok(major), Ok(minor)) = (major, minor)
    {
        // Before 1.0 a minor version may change the structures.
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libtrocar_c.so.{major}.{minor}");
    }
}
