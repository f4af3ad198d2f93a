//! A line in a registry of built-in parts:
//!
//! ```text
//! "word in scenarios" => Kind = file::Part { name: Settings },
//! ```
//! It defines the kind's word, the settings of all parts, and the enum with static dispatch over lanes. Several parts
//! may read the same settings: a key acts for the kinds that read it.

/// The registry of architectures. `shared` lists the settings of several kinds.
macro_rules! architectures {
    (
        $(#[doc = $about:literal])*
        shared { $($shared:ident: $Shared:ident),* $(,)? }
        $($word:literal => $Kind:ident = $file:ident :: $Part:ident $({ $own:ident: $Own:ident })?,)*
    ) => {
        $($(pub use architecture::$file::$Own;)?)*

        trocar_core::choice! {
            $(#[doc = $about])*
            #[derive(Debug, Clone, Copy, PartialEq, Eq)]
            pub enum ControllerKind at "controller.kind" = PositionForce {
                $($word => $Kind,)*
            }
        }

        impl ControllerKind {
            /// The kinds that read these keys.
            const fn built_from(keys: &[trocar_core::settings::Key]) -> trocar_core::settings::ActsFor {
                use architecture::BuiltInArchitecture;
                let kinds = &[$(($word, <architecture::$file::$Part<f64> as BuiltInArchitecture<f64>>::KEYS)),*];
                trocar_core::settings::ActsFor::built_from(keys, Self::KEY.path, kinds)
            }

            /// Whether the feedback force depends on both machines' positions, so that the slave sends its position.
            #[must_use]
            pub fn couples_positions(self) -> bool {
                use architecture::BuiltInArchitecture;
                match self {
                    $(Self::$Kind => architecture::$file::$Part::<f64>::COUPLES_POSITIONS,)*
                }
            }

            /// Whether the gains depend on the slave's dynamics ([`Machines::slave_drag`] and
            /// [`Machines::slave_inertia`]).
            #[must_use]
            pub fn models_slave(self) -> bool {
                use architecture::BuiltInArchitecture;
                match self {
                    $(Self::$Kind => architecture::$file::$Part::<f64>::MODELS_SLAVE,)*
                }
            }
        }

        trocar_core::settings! {
            /// The kind of architecture, and the settings of all kinds.
            #[derive(Debug, Clone, Copy, PartialEq)]
            pub struct ControllerSettings in "controller." {
                /// The kind.
                kind: ControllerKind,
                $(
                    /// Settings of several kinds.
                    $shared: $Shared for (ControllerKind::built_from($Shared::KEYS)),
                )*
                $($(
                    /// Settings of one kind.
                    $own: $Own for (ControllerKind::built_from($Own::KEYS)),
                )?)*
            }
        }

        impl ControllerSettings {
            /// The gains for two machines.
            ///
            /// # Errors
            /// [`InvalidValue`](trocar_core::error::InvalidValue) if the law divides by `K_p` and `K_p` is 0.
            pub fn gains(&self, machines: &Machines) -> Result<(MasterGains, SlaveGains), trocar_core::error::InvalidValue> {
                use architecture::BuiltInArchitecture;
                match self.kind {
                    $(ControllerKind::$Kind => architecture::$file::$Part::<f64>::gains(self, machines),)*
                }
            }
        }

        /// A built-in architecture.
        #[derive(Debug, Clone)]
        pub enum AnyArchitecture<L> {
            $(#[doc = concat!("`", $word, "`")] $Kind(architecture::$file::$Part<L>),)*
        }

        impl<L: trocar_core::lane::Lane> AnyArchitecture<L> {
            /// The chosen architecture, with a tick of `tick_s` (s).
            pub(super) fn new(
                settings: &ControllerSettings,
                machines: &Machines,
                tick_s: f64,
            ) -> Result<Self, trocar_core::error::InvalidValue> {
                use architecture::BuiltInArchitecture;
                Ok(match settings.kind {
                    $(ControllerKind::$Kind => {
                        Self::$Kind(architecture::$file::$Part::build(settings, machines, tick_s)?)
                    })*
                })
            }
        }

        impl<L: trocar_core::lane::Lane> Architecture<L> for AnyArchitecture<L> {
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

        trocar_core::lane::gather_variants!(AnyArchitecture { $($Kind),* });
    };
}

/// The registry of passivity schemes. Settings of several kinds are declared with the first.
macro_rules! schemes {
    (
        $(#[doc = $about:literal])*
        $(
            $word:literal => $Kind:ident = $file:ident :: $Part:ident $({ $own:ident: $Own:ident })?
                $(shared { $shared:ident: $Shared:ident })?,
        )*
    ) => {
        $($(pub use passivity::$file::$Own;)?)*

        trocar_core::choice! {
            $(#[doc = $about])*
            #[derive(Debug, Clone, Copy, PartialEq, Eq)]
            pub enum Scheme at "passivity.scheme" = None {
                $($word => $Kind,)*
            }
        }

        impl Scheme {
            /// The kinds that read these keys.
            const fn built_from(keys: &[trocar_core::settings::Key]) -> trocar_core::settings::ActsFor {
                use passivity::BuiltInScheme;
                let kinds = &[$(($word, <passivity::$file::$Part<f64> as BuiltInScheme<f64>>::KEYS)),*];
                trocar_core::settings::ActsFor::built_from(keys, Self::KEY.path, kinds)
            }

            /// Whether the slave's position reaches the master besides the payload.
            #[must_use]
            pub fn carries_positions(self) -> bool {
                use passivity::BuiltInScheme;
                match self {
                    $(Self::$Kind => passivity::$file::$Part::<f64>::CARRIES_POSITIONS,)*
                }
            }
        }

        trocar_core::settings! {
            /// The scheme, and the settings of all schemes.
            #[derive(Debug, Clone, Copy, PartialEq)]
            pub struct PassivitySettings in "passivity." {
                /// The scheme.
                scheme: Scheme,
                $(
                    $(
                        /// Settings of one kind.
                        $own: $Own for (Scheme::built_from($Own::KEYS)),
                    )?
                    $(
                        /// Settings of several kinds.
                        $shared: $Shared for (Scheme::built_from($Shared::KEYS)),
                    )?
                )*
            }
        }

        impl PassivitySettings {
            /// The keys and values of the dampings (N·s/m) that the scheme holds over a tick at the master.
            pub fn held_dampings(&self) -> [Option<(&'static str, f64)>; 2] {
                use passivity::BuiltInScheme;
                match self.scheme {
                    $(Scheme::$Kind => <passivity::$file::$Part<f64> as BuiltInScheme<f64>>::held_dampings(self),)*
                }
            }
        }

        /// A built-in passivity scheme.
        #[derive(Debug, Clone)]
        pub enum AnyScheme<L> {
            $(#[doc = concat!("`", $word, "`")] $Kind(passivity::$file::$Part<L>),)*
        }

        impl<L: trocar_core::lane::Lane> AnyScheme<L> {
            /// The chosen scheme.
            fn new(settings: &PassivitySettings, context: &passivity::SchemeContext<L>) -> Self {
                use passivity::BuiltInScheme;
                match settings.scheme {
                    $(Scheme::$Kind => Self::$Kind(passivity::$file::$Part::build(settings, context)),)*
                }
            }
        }

        impl<L: trocar_core::lane::Lane> PassivityScheme<L> for AnyScheme<L> {
            #[inline(always)]
            fn sends_payload(&self) -> bool {
                match self { $(Self::$Kind(part) => PassivityScheme::<L>::sends_payload(part),)* }
            }

            #[inline(always)]
            fn master_sends(&mut self, displacement_m: L) -> Payload<L> {
                match self { $(Self::$Kind(part) => part.master_sends(displacement_m),)* }
            }

            #[inline(always)]
            fn receive_position(&mut self, position_m: L, arrived: &Arrived<L>, port: &SlavePort<L>) -> L {
                match self { $(Self::$Kind(part) => part.receive_position(position_m, arrived, port),)* }
            }

            #[inline(always)]
            fn limit_reference(&mut self, reference_m: L, port: &SlavePort<L>) -> L {
                match self { $(Self::$Kind(part) => part.limit_reference(reference_m, port),)* }
            }

            #[inline(always)]
            fn slave_sends(&mut self) -> Payload<L> {
                match self { $(Self::$Kind(part) => part.slave_sends(),)* }
            }

            #[inline(always)]
            fn receive_force(&mut self, force_n: L, arrived: &Arrived<L>, velocity_m_per_s: L) -> L {
                match self { $(Self::$Kind(part) => part.receive_force(force_n, arrived, velocity_m_per_s),)* }
            }

            #[inline(always)]
            fn limit_force(&mut self, force_n: L, velocity_m_per_s: L) -> L {
                match self { $(Self::$Kind(part) => part.limit_force(force_n, velocity_m_per_s),)* }
            }

            fn energies(&self) -> SchemeEnergies<L> {
                match self { $(Self::$Kind(part) => part.energies(),)* }
            }
        }

        trocar_core::lane::gather_variants!(AnyScheme { $($Kind),* });
    };
}
