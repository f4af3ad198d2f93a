//! The page in a real browser: Debian's chromium, driven by its chromedriver.
//!
//! They take minutes and run with `cargo test --test browser -- --ignored`. Without a browser they are skipped with a
//! message; with `TROCAR_BROWSER=required` they fail.
//! `TROCAR_SCREENSHOTS=docs cargo test --test browser screenshots -- --ignored` writes the pictures of the README.

mod charts;
mod page;
mod picture;
mod pushing;
mod similar;
mod steps;
mod tasks;
mod trials;

#[path = "../it/support/server.rs"]
#[allow(dead_code, reason = "shared with tests that need more of it")]
mod server;

#[path = "../it/support/test_folder.rs"]
#[allow(dead_code, reason = "shared with tests that need more of it")]
mod test_folder;

use libtest_mimic::{Arguments, Trial};

fn main() {
    let arguments = Arguments::from_args();
    let required = std::env::var("TROCAR_BROWSER").is_ok_and(|word| word == "required");
    let is_asked = arguments.ignored || arguments.include_ignored;
    let runs = is_asked && !arguments.list && (required || page::is_there());
    if is_asked && !runs && !arguments.list {
        eprintln!(
            "left out: the tests in a browser, as there is no chromium with a chromedriver (Debian: chromium, chromium-driver)"
        );
        return;
    }
    let driver = runs.then(page::driver);
    let port = driver.as_ref().map_or(0, |(_, port)| *port);
    let trial = |(name, run): (&'static str, page::Body)| {
        Trial::test(name, move || page::run(run, port).map_err(Into::into)).with_ignored_flag(true)
    };
    let conclusion = libtest_mimic::run(&arguments, trials::ALL.into_iter().map(trial).collect());
    // Exiting runs no destructors.
    drop(driver);
    conclusion.exit();
}
