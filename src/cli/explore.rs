use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};

use clap::Args;

use super::error::Failure;
use super::{ScenarioArgs, interrupt, terminal};
use crate::explore::{Catalogue, Options, serve};
use trocar_scenario::Source;

const DEFAULT_SCENARIO: &str = "paper/augmented";

const EXAMPLES: &str = "\
Examples:
  trocar explore                                the shipped insertion
  trocar explore layers/skin-augmented          insertion through the skin
  trocar explore my.toml --port 8000 --no-open  your scenario";

/// Explore a scenario in the browser.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct ExploreArgs {
    /// A scenario file, or a shipped scenario such as paper/augmented
    #[arg(value_name = "SCENARIO", default_value = DEFAULT_SCENARIO)]
    scenario: String,
    /// The port of the server; 0 for any free port
    #[arg(long, default_value_t = 8417)]
    port: u16,
    /// The address of the server; 0.0.0.0 gives access to every machine on your network that has the token in the
    /// printed address
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    bind: IpAddr,
    /// Do not open the browser
    #[arg(long)]
    no_open: bool,
}

pub(super) fn run(args: &ExploreArgs) -> Result<(), Failure> {
    // Load the scenario once, so that its errors are reported here and not on the page.
    ScenarioArgs { settings: vec![] }.load(std::slice::from_ref(&args.scenario))?;
    let options = Options {
        address: args.bind,
        port: args.port,
        catalogue: Catalogue::new(Some(&args.scenario)),
        first: Source::parse(&args.scenario).display(),
    };
    // This is how a server ends, and there is nothing to be stored.
    interrupt::on_first(|| std::process::exit(0));
    serve(options, |address, query| {
        // A browser cannot open an unspecified address.
        let is_unspecified = address.ip().is_unspecified();
        let local = match address {
            SocketAddr::V4(_) if is_unspecified => IpAddr::V4(Ipv4Addr::LOCALHOST),
            SocketAddr::V6(_) if is_unspecified => IpAddr::V6(Ipv6Addr::LOCALHOST),
            _ => address.ip(),
        };
        let page = format!("http://{}/{query}", SocketAddr::new(local, address.port()));
        let network =
            if is_unspecified { "\nand on all network addresses of this machine, with the same token" } else { "" };
        // Ignores a closed terminal, so that the server continues.
        let _ = terminal::print(&format!("exploring {} at {page}{network}\nCtrl-C ends the server\n", args.scenario));
        if !args.no_open {
            // Without a browser, the user can copy the printed address.
            let _ = open::that_detached(page);
        }
    })?;
    Ok(())
}
