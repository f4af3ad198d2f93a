//! The kinds of tissue by the words that scenarios use: one line each.

use super::{
    Generalised, GeneralisedSettings, HuntCrossley, HuntCrossleySettings, KelvinVoigt, KelvinVoigtSettings, Layers,
    LayersParameters, ReplaySettings, Tissue,
};
use crate::error::{InvalidValue, require};
use crate::lane::Lane;

/// A tissue that is made of settings alone.
pub trait Model: Sized {
    /// What it is told.
    type Settings;

    /// A tissue of the settings on ticks of `tick_s` (s), of a needle whose tip begins at `start_m` (m).
    ///
    /// # Errors
    /// [`InvalidValue`] naming the setting out of range.
    fn build(settings: &Self::Settings, tick_s: f64, start_m: f64) -> Result<Self, InvalidValue>;
}

macro_rules! tissues {
    (
        $(#[doc = $about:literal])*
        $recording_word:literal => $recording:ident($recording_settings:ident),
        $($(#[doc = $doc:literal])* $word:literal => $model:ident($settings:ident),)*
    ) => {
        trocar_core::choice! {
            $(#[doc = $about])*
            #[derive(Debug, Clone, PartialEq)]
            pub enum TissueSettings at "tissue.kind" = $recording no const {
                /// A recording.
                $recording_word => $recording($recording_settings),
                $($(#[doc = $doc])* $word => $model($settings),)*
            }
        }

        impl TissueSettings {
            /// The tissue on ticks of `tick_s` (s), of a needle whose tip begins at `start_m` (m).
            ///
            /// # Errors
            /// [`InvalidValue`] naming the setting out of range, or the kind of a recording, which takes the recording too.
            pub fn build<L: Lane>(&self, tick_s: f64, start_m: f64) -> Result<Tissue<L>, InvalidValue> {
                Ok(match self {
                    Self::$recording(_) => {
                        require("tissue.kind", 0.0, false, "replayed with its recording")?;
                        Tissue::nothing()
                    }
                    $(Self::$model(settings) => {
                        Tissue::$model(<$model<L> as Model>::build(settings, tick_s, start_m)?.into())
                    })*
                })
            }
        }
    };
}

tissues! {
    /// Replays the recording's force over time, or answers as a spring and damper, even (eq. 1), stiffening (eq. 2) or
    /// varying with depth (eq. 3-4), or as layers that give way.
    "recording" => Recording(ReplaySettings),
    /// A spring and a damper in parallel (eq. 1).
    "kelvin-voigt" => KelvinVoigt(KelvinVoigtSettings),
    /// A spring and a damper that stiffen with depth (eq. 2).
    "hunt-crossley" => HuntCrossley(HuntCrossleySettings),
    /// A spring and a damper whose coefficients vary with depth (eq. 3-4).
    "generalised" => Generalised(GeneralisedSettings),
    /// Layers that bulge, give way, are cut through, and hold the shaft.
    "layers" => Layers(LayersParameters),
}
