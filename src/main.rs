use std::process::ExitCode;

fn main() -> ExitCode {
    trocar::main()
}
