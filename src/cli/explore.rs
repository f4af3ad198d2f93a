//! `trocar explore`.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};

use clap::Args;

use super::error::CliError;
use super::{ScenarioArgs, terminal};
use crate::explore::{Catalogue, Options, serve};

/// The scenario that is explored when none is named.
const FIRST: &str = "builtin:augmented.toml";

/// Open a page to explore.
#[derive(Debug, Args)]
pub(super) struct ExploreArgs {
    /// A scenario file, or a shipped one as builtin:augmented.toml
    #[arg(value_name = "SCENARIO", default_value = FIRST)]
    scenario: String,
    /// The port to serve on; 0 for any that is free
    #[arg(long, default_value_t = 8417)]
    port: u16,
    /// The address to serve on; 0.0.0.0 lets every machine of your network in
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    bind: IpAddr,
    /// Do not open the browser
    #[arg(long)]
    no_open: bool,
}

pub(super) fn run(args: &ExploreArgs) -> Result<(), CliError> {
    // What is wrong with the file is said here, where it can be mended, and not on the page.
    ScenarioArgs { settings: vec![] }.load(std::slice::from_ref(&args.scenario))?;
    let options = Options {
        address: args.bind,
        port: args.port,
        catalogue: Catalogue::new(Some(&args.scenario)),
        first: args.scenario.clone(),
    };
    serve(options, |address| {
        // An address that stands for all of the machine's is none to be opened.
        let everywhere = address.ip().is_unspecified();
        let here = match address {
            SocketAddr::V4(_) if everywhere => IpAddr::V4(Ipv4Addr::LOCALHOST),
            SocketAddr::V6(_) if everywhere => IpAddr::V6(Ipv6Addr::LOCALHOST),
            _ => address.ip(),
        };
        let page = format!("http://{}/", SocketAddr::new(here, address.port()));
        let others = if everywhere { ", and to other machines at this one's addresses" } else { "" };
        // A terminal that is gone need not keep the page from being served.
        let _ = terminal::print(&format!("exploring {} at {page}{others}\nCtrl-C ends it\n", args.scenario));
        if !args.no_open {
            // Where there is no browser to open, the address above is there to be copied.
            let _ = open::that_detached(page);
        }
    })?;
    Ok(())
}
