//! What a line in a registry of built-in parts stands for:
//!
//! ```text
//! Kind "word in TOML" = file::Part { Settings },
//! ```
//! The kind by its word, the settings of all parts under the names of their files, and the enum that runs whichever part was
//! chosen, over lanes, without a call.

/// An enum of kinds, each with its word in TOML.
macro_rules! words {
    ($(#[$doc:meta])* $Name:ident { $($(#[$of_kind:meta])* $Kind:ident $word:literal),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $Name {
            $($(#[$of_kind])* $Kind,)*
        }

        impl $Name {
            /// The words in TOML, the default first.
            pub const WORDS: &'static [&'static str] = &[$($word),*];

            /// The word in TOML.
            #[must_use]
            pub const fn word(self) -> &'static str {
                match self {
                    $(Self::$Kind => $word,)*
                }
            }

            /// The kind of this word; none where the word is unknown.
            #[must_use]
            pub fn from_word(word: &str) -> Option<Self> {
                match word {
                    $($word => Some(Self::$Kind),)*
                    _ => None,
                }
            }
        }
    };
}

/// The registry of architectures; the first one is the paper's.
macro_rules! architectures {
    ($($Kind:ident $word:literal = $file:ident :: $Part:ident $({ $Settings:ident })?),* $(,)?) => {
        $($(pub use architecture::$file::$Settings;)?)*

        words! {
            /// Who is sent what.
            ControllerKind {
                $(#[doc = concat!("`", $word, "`")] $Kind $word),*
            }
        }

        impl ControllerKind {
            /// Whether the force that is fed back depends on where both machines are, so that the slave sends its position.
            #[must_use]
            pub fn couples_positions(self) -> bool {
                use architecture::BuiltInArchitecture;
                match self {
                    $(Self::$Kind => architecture::$file::$Part::<f64>::COUPLES_POSITIONS,)*
                }
            }

            /// Whether its gains follow from how the slave moves ([`Machines::slave_drag`] and
            /// [`Machines::slave_inertia`]).
            #[must_use]
            pub fn models_slave(self) -> bool {
                use architecture::BuiltInArchitecture;
                match self {
                    $(Self::$Kind => architecture::$file::$Part::<f64>::MODELS_SLAVE,)*
                }
            }
        }

        /// The architecture and the gains that each leaves open.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct ControllerSettings {
            /// Who is sent what.
            pub kind: ControllerKind,
            $($(#[doc = concat!("Those of `", $word, "`.")] pub $file: $Settings,)?)*
        }

        impl ControllerSettings {
            /// The paper's, beside gains for the others that are chosen here.
            pub const PAPER: Self = Self {
                kind: ControllerKind::PositionForce,
                $($($file: $Settings::DEFAULT,)?)*
            };

            /// Checks the ranges that the settings state.
            ///
            /// # Errors
            /// [`InvalidValue`](crate::error::InvalidValue) naming the first setting out of range.
            pub fn validate(&self) -> Result<(), crate::error::InvalidValue> {
                $($($Settings::validate(&self.$file)?;)?)*
                Ok(())
            }

            /// The gains around two machines.
            ///
            /// # Errors
            /// [`InvalidValue`](crate::error::InvalidValue) where a law of the slave needs a `K_p` that is 0.
            pub fn gains(&self, machines: &Machines) -> Result<(MasterGains, SlaveGains), crate::error::InvalidValue> {
                use architecture::BuiltInArchitecture;
                match self.kind {
                    $(ControllerKind::$Kind => architecture::$file::$Part::<f64>::gains(self, machines),)*
                }
            }
        }

        /// A built-in architecture at work.
        #[derive(Debug, Clone)]
        pub enum AnyArchitecture<L> {
            $(#[doc = concat!("`", $word, "`")] $Kind(architecture::$file::$Part<L>),)*
        }

        impl<L: crate::lane::Lane> AnyArchitecture<L> {
            /// The one that is chosen, on ticks of `tick_s` (s).
            fn new(
                settings: &ControllerSettings,
                machines: &Machines,
                tick_s: f64,
            ) -> Result<Self, crate::error::InvalidValue> {
                use architecture::BuiltInArchitecture;
                Ok(match settings.kind {
                    $(ControllerKind::$Kind => {
                        Self::$Kind(architecture::$file::$Part::build(settings, machines, tick_s)?)
                    })*
                })
            }
        }

        impl<L: crate::lane::Lane> Architecture<L> for AnyArchitecture<L> {
            #[inline(always)]
            fn master_sends(&mut self, master: &AtMaster<L>) -> MasterSample<L> {
                match self { $(Self::$Kind(part) => part.master_sends(master),)* }
            }

            #[inline(always)]
            fn slave_target(&mut self, arrived: &MasterSample<L>, slave: &AtSlave<L>) -> L {
                match self { $(Self::$Kind(part) => part.slave_target(arrived, slave),)* }
            }

            #[inline(always)]
            fn slave_sends(&mut self, slave: &AtSlave<L>, force_n: L) -> SlaveSample<L> {
                match self { $(Self::$Kind(part) => part.slave_sends(slave, force_n),)* }
            }

            #[inline(always)]
            fn master_force(&mut self, arrived: &ArrivedAtMaster<L>, master: &AtMaster<L>) -> L {
                match self { $(Self::$Kind(part) => part.master_force(arrived, master),)* }
            }
        }

        crate::lane::gather_variants!(AnyArchitecture { $($Kind),* });
    };
}

/// The registry of passivity schemes; the first one does nothing.
macro_rules! schemes {
    ($($Kind:ident $word:literal = $file:ident :: $Part:ident $({ $Settings:ident })?),* $(,)?) => {
        $($(pub use passivity::$file::$Settings;)?)*

        words! {
            /// Which scheme there is.
            Scheme {
                $(#[doc = concat!("`", $word, "`")] $Kind $word),*
            }
        }

        impl Scheme {
            /// Whether positions go back to the master beside what the scheme sends.
            #[must_use]
            pub fn carries_positions(self) -> bool {
                use passivity::BuiltInScheme;
                match self {
                    $(Self::$Kind => passivity::$file::$Part::<f64>::CARRIES_POSITIONS,)*
                }
            }
        }

        /// The scheme and the numbers of each.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct PassivitySettings {
            /// Which scheme there is.
            pub scheme: Scheme,
            /// Those of every scheme that limits the force and meters the reference.
            pub limits: LimitSettings,
            $($(#[doc = concat!("Those of `", $word, "`.")] pub $file: $Settings,)?)*
        }

        impl PassivitySettings {
            /// No scheme, beside numbers for each that are chosen here.
            pub const NONE: Self = Self {
                scheme: Scheme::None,
                limits: LimitSettings::DEFAULT,
                $($($file: $Settings::DEFAULT,)?)*
            };

            /// Checks the ranges that the settings state.
            ///
            /// # Errors
            /// [`InvalidValue`](crate::error::InvalidValue) naming the first setting out of range.
            pub fn validate(&self) -> Result<(), crate::error::InvalidValue> {
                self.limits.validate()?;
                $($($Settings::validate(&self.$file)?;)?)*
                Ok(())
            }
        }

        /// A built-in passivity scheme at work.
        #[derive(Debug, Clone)]
        pub enum AnyScheme<L> {
            $(#[doc = concat!("`", $word, "`")] $Kind(passivity::$file::$Part<L>),)*
        }

        impl<L: crate::lane::Lane> AnyScheme<L> {
            /// The one that is chosen; the one that does nothing where the chosen one would change nothing.
            fn new(settings: &PassivitySettings, around: &passivity::Surroundings<L>) -> Self {
                use passivity::BuiltInScheme;
                let built = match settings.scheme {
                    $(Scheme::$Kind => passivity::$file::$Part::build(settings, around).map(Self::$Kind),)*
                };
                built.unwrap_or(Self::None(passivity::no_scheme::NoScheme::default()))
            }
        }

        impl<L: crate::lane::Lane> PassivityScheme<L> for AnyScheme<L> {
            #[inline(always)]
            fn master_sends(&mut self, displacement_m: L) -> L {
                match self { $(Self::$Kind(part) => part.master_sends(displacement_m),)* }
            }

            #[inline(always)]
            fn receive_position(&mut self, position_m: L, payload: L, port: &SlavePort<L>) -> L {
                match self { $(Self::$Kind(part) => part.receive_position(position_m, payload, port),)* }
            }

            #[inline(always)]
            fn limit_reference(&mut self, reference_m: L, payload: L, port: &SlavePort<L>) -> L {
                match self { $(Self::$Kind(part) => part.limit_reference(reference_m, payload, port),)* }
            }

            #[inline(always)]
            fn slave_sends(&mut self) -> L {
                match self { $(Self::$Kind(part) => part.slave_sends(),)* }
            }

            #[inline(always)]
            fn receive_force(&mut self, force_n: L, payload: L, velocity_m_per_s: L) -> L {
                match self { $(Self::$Kind(part) => part.receive_force(force_n, payload, velocity_m_per_s),)* }
            }

            #[inline(always)]
            fn limit_force(&mut self, force_n: L, payload: L, velocity_m_per_s: L) -> L {
                match self { $(Self::$Kind(part) => part.limit_force(force_n, payload, velocity_m_per_s),)* }
            }

            fn dissipated_j(&self) -> L {
                match self { $(Self::$Kind(part) => part.dissipated_j(),)* }
            }

            fn refused_j(&self) -> L {
                match self { $(Self::$Kind(part) => part.refused_j(),)* }
            }
        }

        crate::lane::gather_variants!(AnyScheme { $($Kind),* });
    };
}
