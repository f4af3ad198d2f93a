/// `trocar` and its arguments, quoted for a shell where necessary.
pub fn command_line<S: AsRef<str>>(arguments: impl IntoIterator<Item = S>) -> String {
    arguments.into_iter().fold("trocar".to_owned(), |line, argument| format!("{line} {}", quoted(argument.as_ref())))
}

fn quoted(argument: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,+@%^".contains(c);
    if !argument.is_empty() && argument.chars().all(is_plain) {
        argument.to_owned()
    } else {
        format!("'{}'", argument.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_back_the_arguments() {
        let given = ["run", "it's here.toml", "--set", "a.b=[1, 2]", "", "$(reboot)", "plain.toml"];
        let line = command_line(given);
        assert_eq!(line, r"trocar run 'it'\''s here.toml' --set 'a.b=[1, 2]' '' '$(reboot)' plain.toml");
    }
}
