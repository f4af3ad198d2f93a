//! The commands in two groups, because clap has no headings for commands.

use clap::Command;

/// The commands of the second group.
const FILES_AND_SETUP: [&str; 5] = ["init", "schema", "record", "completions", "man"];

pub(super) fn grouped(command: Command) -> Command {
    let is_setup = |inner: &Command| FILES_AND_SETUP.contains(&inner.get_name());
    let main = list(command.clone().disable_help_subcommand(true), |inner| !is_setup(inner));
    let setup = list(command.clone(), is_setup);
    let heading = command.get_styles().get_header();
    let title = |text: &str| format!("{heading}{text}:{heading:#}");
    let (commands, files, options) = (title("Commands"), title("Files and setup"), title("Options"));
    command.help_template(format!(
        "{{before-help}}{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n\
         {commands}\n{main}\n\n{files}\n{setup}\n\n{options}\n{{options}}{{after-help}}"
    ))
}

fn list(command: Command, is_kept: impl Fn(&Command) -> bool) -> String {
    let hide = |inner: Command| {
        let is_hidden = !is_kept(&inner);
        inner.hide(is_hidden)
    };
    let lines = command.mut_subcommands(hide).help_template("{subcommands}").render_help().ansi().to_string();
    lines.trim_end().to_owned()
}
