use clap::builder::PossibleValuesParser;
use clap::{Arg, Args, Command, CommandFactory, ValueHint};
use clap_complete::Shell;

use super::error::Failure;
use super::{Cli, terminal};
use trocar_scenario::{KEYS, shipped_questions};

const EXAMPLES: &str = "\
Examples:
  trocar completions bash > ~/.local/share/bash-completion/completions/trocar
  trocar completions zsh > \"${fpath[1]}/_trocar\"
  trocar completions fish > ~/.config/fish/completions/trocar.fish";

/// Print completions for a shell.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

pub(super) fn run(args: &CompletionsArgs) -> Result<(), Failure> {
    let mut script = vec![];
    clap_complete::generate(args.shell, &mut with_values(Cli::command()), "trocar", &mut script);
    let script = String::from_utf8_lossy(&script).into_owned();
    terminal::print(&match args.shell {
        Shell::Zsh => with_zsh_functions(&script),
        Shell::Fish => script + &fish_scenarios(),
        _ => script,
    })
}

fn scenarios() -> Vec<&'static str> {
    shipped_questions().map(|(path, _)| path.trim_end_matches(".toml")).collect()
}

/// With the `=` that follows each key.
fn settings() -> Vec<String> {
    KEYS.iter().map(|key| format!("{}=", key.path)).collect()
}

/// For the scripts only: the parser would refuse others.
fn with_values(command: Command) -> Command {
    let add = |arg: Arg| {
        if expects_scenario(&arg) {
            arg.value_parser(PossibleValuesParser::new(scenarios()))
        } else if arg.get_long() == Some("set") {
            // This hint keeps bash from adding a space after the `=`.
            arg.value_parser(PossibleValuesParser::new(settings())).value_hint(ValueHint::Other)
        } else {
            arg
        }
    };
    command.mut_args(add).mut_subcommands(with_values)
}

fn expects_scenario(arg: &Arg) -> bool {
    let names = arg.get_value_names().unwrap_or_default();
    arg.is_positional() && names.iter().any(|name| name.split('|').any(|word| word == "SCENARIO"))
}

/// A list of scenarios or keys would exclude files and add a space after the `=`.
fn with_zsh_functions(script: &str) -> String {
    let (scenarios, settings) = (scenarios().join(" "), settings().join(" "));
    let functions = format!(
        "_trocar_scenarios() {{
    local ret=1
    compadd -- {scenarios} && ret=0
    _files && ret=0
    return ret
}}

_trocar_settings() {{
    compadd -S '' -- {settings}
}}

"
    );
    script
        .replace(&format!("({scenarios})"), "_trocar_scenarios")
        .replace(&format!("({settings})"), "_trocar_settings")
        .replacen("_trocar() {", &format!("{functions}_trocar() {{"), 1)
}

/// The fish completions of positional arguments, which clap leaves out.
fn fish_scenarios() -> String {
    let command = Cli::command();
    let expects = |command: &Command| command.get_arguments().any(expects_scenario);
    let takes_scenarios = |command: &&Command| expects(command) || command.get_subcommands().any(expects);
    let names = scenarios().join(" ");
    let line = |command: &Command| {
        format!("complete -c trocar -n \"__fish_trocar_using_subcommand {}\" -a \"{names}\"\n", command.get_name())
    };
    command.get_subcommands().filter(takes_scenarios).map(line).collect()
}
