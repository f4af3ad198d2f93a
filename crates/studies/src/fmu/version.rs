#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    Two,
    Three,
}

impl Version {
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
