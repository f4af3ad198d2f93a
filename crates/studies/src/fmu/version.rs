/// A version of the standard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

impl Version {
    /// The folder of the library for this machine.
    pub fn platform(self) -> String {
        let (system, architecture) = (std::env::consts::OS, std::env::consts::ARCH);
        match self {
            Self::Two => {
                let system = match system {
                    "windows" => "win",
                    "macos" => "darwin",
                    other => other,
                };
                // The standard names machines by 32 or 64 bits, not by their architecture.
                format!("{system}{}", usize::BITS)
            }
            Self::Three => {
                let system = if system == "macos" { "darwin" } else { system };
                format!("{architecture}-{system}")
            }
        }
    }
}
