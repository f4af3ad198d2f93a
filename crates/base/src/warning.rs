use std::fmt::{self, Display, Formatter};

use serde::{Serialize, Serializer};

use super::names::with_short_words;

/// Rows: variant, word, meaning and explanation.
macro_rules! codes {
    ($($Code:ident $word:literal: $meaning:literal, $more:literal;)*) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Code {
            $(#[doc = $meaning] $Code,)*
        }

        impl Code {
            pub const ALL: &'static [Self] = &[$(Self::$Code),*];

            pub fn word(self) -> &'static str {
                match self {
                    $(Self::$Code => $word,)*
                }
            }

            pub fn meaning(self) -> &'static str {
                match self {
                    $(Self::$Code => $meaning,)*
                }
            }

            pub fn explanation(self) -> &'static str {
                match self {
                    $(Self::$Code => $more,)*
                }
            }
        }
    };
}

codes! {
    MissedRupture "missed-rupture":
        "A layer ruptured, and no alarm followed within 0.1 s.",
        "trocar repeats the run and observes the detector. Among the samples after the rupture with g above the \
         threshold, it selects those that fail the fewest conditions; the first of them gives the reason. The message \
         names the key that sets the failed condition. If g stays below the threshold, the message reports the \
         largest g.";
    Oscillating "oscillating":
        "The needle or the master swings, and the swing does not decay.",
        "The check applies to a run in which the position relative to the desired position reverses in the last 40 %, \
         and still moves in the last 20 %, by more than 20 µm and twice the resolution of the position sensor. The run \
         is then repeated and continued without excitation: the hand rests at its last desired position, the organs \
         stop, and the force sensor has no noise; delays, losses, limits, augmentation and reflexes of the arm remain. \
         The loop causes the swing if the swing persists: over consecutive windows it does not weaken, or it \
         approaches a smaller persistent swing. The continuation is as long as the run, and is doubled until this is \
         clear: up to 64 times, 8 times with random losses or delays, 4 times with `dop853`, at most 400,000 \
         ticks; with random losses the swing persists if at least half of its strength remains at the end. If the hand \
         was still moving, it also rests where it was deepest in the last 20 %; the swing there counts if the run \
         swings without becoming weaker, at least half as fast and half as far. A stick-slip that needs a moving hand \
         does not count as a swing of the loop.";
    ActiveLoop "active-loop":
        "The master gives the hand more energy than hand and tissue have supplied.",
        "The tissue is a passive model, but the work of the hand on the master is negative: the teleoperator feeds \
         energy to the hand. A passive teleoperator does not. With a delay, a passivity scheme can prevent it.";
    LimitActs "limit-acts":
        "A limit of the safety stage changed a command.",
        "With safety.acts = \"everywhere\" the limits of a rig act in the simulation, too. The message gives the number of ticks at \
         which a command was at the limit. The run then shows the effect of the limit on the overshoot and on the felt force.";
    PeerSilent "peer-silent":
        "Nothing came from the other side of a link for longer than three outages.",
        "The other process has ended or stands still, or the network has failed. The slave's reference holds after channel.outage_s, \
         and the master's force decays to 0 after channel.dead_s within channel.dead_decay_s. If messages come again, reference \
         and force return at their recovery rates. If the other side is silent at the end, the exit code is 1.";
    PeerRestarted "peer-restarted":
        "A side of a link was started anew while the link ran.",
        "The new process has joined the link of the other one: after a new greeting, from the present tick to the end. Its machine \
         began at its start, and it computed the ticks before without messages. Reference and force return at their recovery \
         rates. The exit code of both sides is 1, and a replay refuses the logs.";
    PromiseBroken "promise-broken":
        "A passivity scheme has generated more energy than it promises.",
        "A scheme promises that the ports at the hand and at the needle never deliver more than they have received and \
         E_0: E_m - E_s >= -E_0 with E_m = sum F_ed dx_h and E_s = integral f_e dx_e, scaled to the master. The \
         promise does not cover a tissue stiffer than passivity.max_stiffness_n_per_m, actuators that saturate, and \
         sensors that are not ideal.";
    PromiseNotCovered "promise-not-covered":
        "The promise of the passivity scheme does not cover a part of the scenario.",
        "A scheme keeps its promise for ideal sensors and motors, a slave that the tissue does not move, and tissues \
         up to passivity.max_stiffness_n_per_m. `trocar check` names the parts of a scenario that violate these \
         conditions. The energy may still stay within the promised bound: `trocar run` checks it and warns with \
         promise-broken.";
    DelayBeyondRun "delay-beyond-run":
        "A delay of the link is longer than the run.",
        "No sample arrives during the run.";
    DelayRounded "delay-rounded":
        "A delay of the link is rounded up to a whole number of ticks.",
        "Continuous controllers read a sample when it arrives, also between two ticks. Sampled controllers, other \
         architectures than position-force and passivity schemes compute on the tick: a sample that arrives between \
         two ticks waits for the next one. The run and the analysis of stability use the longer delay, so that they \
         change in steps. Give a multiple of simulation.tick_s, or shorten the tick.";
    TissueNotTouched "tissue-not-touched":
        "The needle never touches the tissue.",
        "The tissue force is 0 in the whole run: no layer can rupture, and a comparison compares free motion. The \
         surface is at tissue.contact_m, in slave positions: the slave moves scaling.position times as far as the \
         master. A common cause is a value in mm that was given as m.";
    LayerNotRuptured "layer-not-ruptured":
        "A layer or a labelled rupture of the scenario does not occur in the run.",
        "The counts of detected and missed ruptures do not include it. The needle does not reach the layer, or its \
         force stays below the layer's rupture force. A layer bulges before it ruptures, so the needle must go deeper \
         than the position of the layer. Let the operator move further, or lengthen the run. Some strategies stop the \
         insertion on purpose.";
    MotionBeyondRun "motion-beyond-run":
        "The operator's movement takes longer than the run.",
        "The run ends before the movement does. Lengthen simulation.duration_s, or shorten operator.movement_s (its \
         unit is s).";
    StrayAlarm "stray-alarm":
        "An alarm near a rupture does not count as its detection.",
        "An alarm detects a rupture if the force has fallen and the alarm follows soon: in a run within 0.1 s of the \
         rupture, in a recording within 0.1 s of a fall of the force. An alarm before the fall, or long after it, has \
         another cause. It counts as false, and the rupture as missed, unless another alarm detects it.";
    OutsideMeasured "outside-measured":
        "A property of the tissue is outside the range of the measurements.",
        "The literature page of the manual lists measured values and the range of each property. trocar simulates \
         values outside the range, too: a firm phantom or another species may need them. Check the unit first.";
    SeedsWithoutEffect "seeds-without-effect":
        "The scenario has no random numbers, so every seed gives the same run.",
        "Seeds vary the noise of the sensors, the tremor, the reaction times, jitter and loss. None of them is \
         active, so repeated runs are identical, and intervals over seeds have no width.";
    UnchangedMetrics "unchanged-metrics":
        "No metric differs between the cases of a sweep.",
        "The axes change nothing that the sweep records. Every summary also lists the metrics that are the same in \
         every case.";
    Unmodelled "unmodelled":
        "The analysis of stability leaves out a part of the scenario.",
        "The linear analysis has no model of the listed parts. Its verdict covers the loop without them; with them the \
         loop may be unstable. `trocar run` simulates them.";
    TissueNotCovered "tissue-not-covered":
        "The certificate does not cover the whole tissue of the scenario.",
        "The certificate covers any force and springs whose stiffness changes at any tick within a range: that of the \
         scenario's tissue, or --tissue LOW:HIGH. The stiffness of the tissue is not within that range.";
    LowSamplingRate "low-sampling-rate":
        "The samples are too far apart to show a rupture.",
        "A rupture takes about 30 ms. At a low rate it falls between two samples, and the defaults of estimator and \
         detector are for intervals of 0.5 to 2 ms. Are the times in milliseconds? Then write --time COLUMN:ms.";
    HighSamplingRate "high-sampling-rate":
        "The sampling rate is higher than that of any force sensor.",
        "The sampling rate is above 100 kHz: the unit of the time is probably wrong.";
    ForceSign "force-sign":
        "The force does not resist the insertion.",
        "Forces are positive when they resist insertion. Loading the tissue then takes work: the force rises while the \
         needle advances. In the recording it falls. A negative unit or factor changes the sign, as in --force \
         COLUMN:-N.";
    ForceMagnitude "force-magnitude":
        "The forces are implausible for a needle in tissue.",
        "The largest force is above 60 N, or below the drop that a detector expects (detector.rupture_std_n), or it \
         rises by more than 20 kN/m. The unit is probably wrong: write it after the column, as in --force COLUMN:mN.";
    PositionMagnitude "position-magnitude":
        "The positions are implausible for a needle insertion.",
        "Insertions span 0.3 mm to 0.5 m. Outside this range the unit is probably wrong: write it after the column, as \
         in --position COLUMN:mm.";
    VelocityMagnitude "velocity-magnitude":
        "The recorded velocity is not the derivative of the recorded position.",
        "The velocity column and the slope of the positions differ by a factor. The message names the factor that \
         makes them agree, for --velocity COLUMN:FACTOR. Without --velocity, the velocity is estimated from the \
         positions.";
    NoContact "no-contact":
        "The needle never reaches the contact position.",
        "The estimator, and every detector except the adaptive one, work below estimator.contact_m only. Give \
         --contact-m at the surface of the tissue.";
    ForceOutOfContact "force-out-of-contact":
        "The largest force of a recording, or the force at an alarm, acts above the contact position.",
        "The estimator, and every detector except the adaptive one, ignore the samples above estimator.contact_m. If \
         the largest force, of at least 1 N, is there, or the adaptive detector raises an alarm there, the contact \
         position is too deep, or the positions decrease into the tissue, or the force has the wrong sign: give a \
         smaller --contact-m, or change the sign of --position or --force.";
    ForceOffset "force-offset":
        "The force is not 0 before the needle touches the tissue.",
        "Over the free motion at the beginning the force is constant and differs from 0: the sensor is not tared. \
         `trocar calibrate` then takes free motion for contact, and the detector raises false alarms. recording.tare_s \
         (--tare-s) subtracts the mean force of the beginning.";
    KeyWithoutEffect "key-without-effect":
        "A given key changes nothing in this command.",
        "The command does not read the key, or computes its value itself: a detection does not simulate a sensor, and \
         a calibration computes threshold and drift. Keys in a scenario file are not reported, since other commands \
         read them.";
    ConstantForce "constant-force":
        "The force does not change although the needle moves in contact.",
        "The sensor is at the end of its range, or its value is not renewed or has coarse steps: no detector can see \
         a rupture during this time. The message gives the time. \
         The adaptive detector counts as not armed once the force has not changed for 0.2 s.";
    SlowRupturesMissed "slow-ruptures-missed":
        "The calibrated settings detect less than half of the slowest inserted ruptures.",
        "The noise hides the slowest ruptures at the requested interval between false alarms. Calibrate on a longer \
         beginning (--first-s), or accept more false alarms (a smaller --false-alarm-s).";
    HarmlessAlarms "harmless-alarms":
        "The calibrated settings raise alarms at more than a fifth of the inserted harmless changes.",
        "The estimator is too slow for changes of stiffness and speed. Calibrate on a longer beginning (--first-s), or \
         accept a longer delay.";
    GuessedColumns "guessed-columns":
        "The columns of a recording are guessed from their names and units.",
        "No flag or key names a column, and no column has a default name, but exactly one signal each looks like \
         time, position and force. Give the flags in the message to confirm this choice, or give others (`trocar \
         detect FILE --list` shows all signals).";
    UnitIgnored "unit-ignored":
        "A column is read in SI units, and the file states another unit.",
        "A column without a factor or a unit is read in s, m, m/s and N. The name of the column, the row of units or the file states \
         another unit: give it after a colon, as in x:mm or load:gf, or a factor.";
    UnfinishedFile "unfinished-file":
        "The file of a recording seems to end before the recording did.",
        "The last line of a text has no line end, or the last part of a TDMS file is not whole. The program that wrote it was \
         stopped, or the file was cut off when it was copied. The last number of such a line can lack digits: add the line end if \
         the line is complete, or remove the line.";
    NoRuptures "no-ruptures":
        "A study of detectors has no rupture.",
        "The recordings have no labelled rupture, so the share of detected ruptures is unknown and every alarm counts \
         as false, even an alarm at a rupture without a label. Label the ruptures with --rupture-s, unless the \
         recordings contain none.";
}

impl Code {
    pub fn parse(word: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|code| code.word() == word)
    }
}

impl Serialize for Code {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.word())
    }
}

/// A warning.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Warning {
    /// Its code.
    pub code: Code,
    /// The finding in one sentence.
    pub message: String,
    /// The scenario, recording or file, if there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// The key, column or flag.
    pub place: Option<String>,
    /// The remedy.
    pub remedy: Option<String>,
}

impl Warning {
    /// Shortens long words of the message.
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        let message = with_short_words(&message.into()).into_owned();
        Self { code, message, source: None, place: None, remedy: None }
    }

    pub fn at(self, place: impl Into<String>) -> Self {
        Self { place: Some(place.into()), ..self }
    }

    pub fn remedy(self, remedy: impl Into<String>) -> Self {
        Self { remedy: Some(with_short_words(&remedy.into()).into_owned()), ..self }
    }

    pub fn of(self, source: impl Into<String>) -> Self {
        Self { source: Some(source.into()), ..self }
    }
}

impl Display for Warning {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let Some(source) = &self.source {
            write!(f, "{source}: ")?;
        }
        f.write_str(&self.message)
    }
}
