//! The list of the built-in tissues, by their words in scenarios.

use trocar_core::settings::{ActsFor, Key, acting, count_distinct, distinct};

use super::literature::Outside;
use super::*;
use trocar_core::error::InvalidValue;

/// Defines the settings and the enum of the built-in tissues, one line each: word, type, type of the settings, and the type of
/// a layer in the list of layers. A recording is replayed by time or by depth, which are two
/// tissues; it and a unit are built from a file.
macro_rules! tissues {
    (
        $(#[doc = $about:literal])*
        $recording_word:literal => $recording:ident($recording_settings:ident) by $time:ident($by_time:ty) $depth:ident($by_depth:ty),
        $unit_word:literal => $unit:ident($unit_settings:ident) of a file,
        $($word:literal => $model:ident($settings:ident) $(layers of $layer:ident)?,)*
    ) => {
        trocar_core::choice! {
            $(#[doc = $about])*
            #[derive(Debug, Clone, PartialEq)]
            pub enum TissueSettings at "tissue.kind" = $recording no const {
                $recording_word => $recording($recording_settings),
                $($word => $model($settings),)*
                $unit_word => $unit($unit_settings),
            }
        }

        /// Any of the built-in tissues.
        #[derive(Debug, Clone)]
        pub enum AnyTissue<L: Lane> {
            /// A recording, replayed by time.
            $time($by_time),
            /// A recording, replayed by depth.
            $depth($by_depth),
            $(#[doc = concat!("See [`", stringify!($model), "`].")] $model($model<L>),)*
            #[doc = concat!("See [`", stringify!($unit), "`].")]
            $unit(Box<$unit<L>>),
            /// Any of them, with a moving surface.
            Moving(Box<Moving<L>>),
        }

        impl TissueSettings {
            /// The keys of a layer in the list of layers, with a `*` for the layer.
            pub const LIST_KEYS: &'static [Key] = {
                const GROUPS: &[&[Key]] = &[$($({
                    const LIST: &[Key] = $layer::KEYS;
                    const COUNT: usize = LIST.len();
                    &acting::<COUNT>(&[LIST], ActsFor::new(TissueSettings::KEY.path, &[$word]))
                },)?)*];
                &distinct::<{ count_distinct(GROUPS) }>(GROUPS)
            };

            /// The layers of the kind with this word where none are listed: their names, each with the values of those keys that
            /// differ from the defaults. Empty for a kind without layers.
            #[must_use]
            pub fn default_layers(word: &str) -> Vec<(&'static str, Vec<(&'static str, f64)>)> {
                match word {
                    $($($word => $layer::default_list(),)?)*
                    _ => vec![],
                }
            }

            /// The names of the layers that rupture, from the surface down.
            #[must_use]
            pub fn rupturing_layers(&self) -> Vec<&str> {
                match self {
                    Self::$recording(_) | Self::$unit(_) => vec![],
                    $(Self::$model(settings) => <$model<f64> as Model>::rupturing_layers(settings),)*
                }
            }

            /// The surface of the undeformed tissue in m; `None` for a recording and a unit.
            #[must_use]
            pub fn surface_m(&self) -> Option<f64> {
                match self {
                    Self::$recording(_) | Self::$unit(_) => None,
                    $(Self::$model(settings) => Some(<$model<f64> as Model>::surface_m(settings)),)*
                }
            }

            /// See [`Model::springs`]; also `None` for a recording and a unit.
            #[must_use]
            pub fn springs(&self, depth_m: Option<f64>) -> Option<Springs> {
                match self {
                    Self::$recording(_) | Self::$unit(_) => None,
                    $(Self::$model(settings) => <$model<f64> as Model>::springs(settings, depth_m),)*
                }
            }

            /// Its properties outside the range of the measurements.
            #[must_use]
            pub fn outside_measured(&self) -> Vec<Outside> {
                match self {
                    Self::$recording(_) | Self::$unit(_) => vec![],
                    $(Self::$model(settings) => <$model<f64> as Model>::outside_measured(settings),)*
                }
            }

            /// Checks what [`TissueSettings::build`] would refuse, without a tissue.
            ///
            /// # Errors
            /// [`InvalidValue`] naming the setting out of range.
            pub fn check(&self, tick_s: f64, start_m: f64) -> Result<(), InvalidValue> {
                match self {
                    Self::$recording(_) | Self::$unit(_) => Ok(()),
                    $(Self::$model(settings) => <$model<f64> as Model>::check(settings, tick_s, start_m),)*
                }
            }

            /// The tissue on ticks of `tick_s` (s), with the needle tip initially at `start_m` (m).
            ///
            /// # Errors
            /// [`InvalidValue`] naming the setting out of range; also for a recording and for a unit, whose tissues need
            /// their file.
            pub fn build<L: Lane>(&self, tick_s: f64, start_m: f64) -> Result<AnyTissue<L>, InvalidValue> {
                match self {
                    Self::$recording(_) | Self::$unit(_) => Err(InvalidValue {
                        name: "tissue.kind",
                        value: 0.0,
                        requirement: "built with its file",
                        item: None,
                    }),
                    $(Self::$model(settings) => Model::build(settings, tick_s, start_m).map(AnyTissue::$model),)*
                }
            }
        }

        impl<L: Lane> Tissue<L> for AnyTissue<L> {
            #[inline(always)]
            fn react(&mut self, tick: u64, position_m: L, velocity_m_per_s: L) -> Reaction<L> {
                match self {
                    Self::$time(part) => part.react(tick, position_m, velocity_m_per_s),
                    Self::$depth(part) => part.react(tick, position_m, velocity_m_per_s),
                    $(Self::$model(part) => part.react(tick, position_m, velocity_m_per_s),)*
                    Self::$unit(part) => part.react(tick, position_m, velocity_m_per_s),
                    Self::Moving(part) => part.react(tick, position_m, velocity_m_per_s),
                }
            }

            #[inline(always)]
            fn shaft_force_n(&self) -> L {
                match self {
                    Self::$time(part) => part.shaft_force_n(),
                    Self::$depth(part) => part.shaft_force_n(),
                    $(Self::$model(part) => part.shaft_force_n(),)*
                    Self::$unit(part) => part.shaft_force_n(),
                    Self::Moving(part) => part.shaft_force_n(),
                }
            }

            fn failure(&self) -> Option<&TissueFailure> {
                match self {
                    Self::$time(part) => Tissue::<L>::failure(part),
                    Self::$depth(part) => part.failure(),
                    $(Self::$model(part) => part.failure(),)*
                    Self::$unit(part) => part.failure(),
                    Self::Moving(part) => part.failure(),
                }
            }
        }

        trocar_core::lane::gather_variants!(AnyTissue { $time, $depth, $($model,)* $unit, Moving });
    };
}

tissues! {
    /// The recording's force, or a spring and damper, linear (eq. 1), stiffening (eq. 2) or varying with depth (eq.
    /// 3-4), or layers that rupture at a force, or by the energy that a crack releases, or the tissue of an FMU.
    "recording" => Recording(ReplaySettings) by Recording(RecordedForce) Depth(DepthReplay<L>),
    "fmu" => Fmu(FmuSettings) of a file,
    "kelvin-voigt" => KelvinVoigt(KelvinVoigtSettings),
    "hunt-crossley" => HuntCrossley(HuntCrossleySettings),
    "generalised" => Generalised(GeneralisedSettings),
    "layers" => Layers(LayersParameters) layers of LayerParameters,
    "tearing" => Tearing(TearingSettings) layers of TearingLayer,
}
