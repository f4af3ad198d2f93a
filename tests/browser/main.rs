//! The page in a real browser: Debian's chromium, driven by its chromedriver.
//!
//! Without a browser the tests are skipped with a message; with `TROCAR_BROWSER=required` they fail.
//! `TROCAR_SCREENSHOTS=docs cargo test --test browser screenshots` writes the pictures of the README.

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
    let there = page::is_there();
    let required = std::env::var("TROCAR_BROWSER").is_ok_and(|word| word == "required");
    if !there && !required && !arguments.list {
        eprintln!(
            "left out: the tests in a browser, as there is no chromium with a chromedriver (Debian: chromium, chromium-driver)"
        );
    }
    let driver = ((there || required) && !arguments.list).then(page::driver);
    let port = driver.as_ref().map_or(0, |(_, port)| *port);
    let trial = |(name, run): (&'static str, page::Body)| {
        Trial::test(name, move || page::run(run, port).map_err(Into::into)).with_ignored_flag(driver.is_none())
    };
    let conclusion = libtest_mimic::run(&arguments, trials::ALL.into_iter().map(trial).collect());
    // Exiting runs no destructors.
    drop(driver);
    conclusion.exit();
}
