use super::column::{ColumnValues, TraceColumn};
use super::{Observer, PortEnergies, Signals, TrustColumns};
use trocar_base::large_pages::with_capacity;
use trocar_base::rows::AT_ONCE;
use trocar_core::time::TickGrid;

/// Faster than the trace as an observer; complete when dropped.
pub struct TraceRecorder<'a> {
    trace: &'a mut Trace,
    ticks: Ticks,
    count: usize,
}

impl Drop for TraceRecorder<'_> {
    fn drop(&mut self) {
        self.append();
    }
}

/// By default a column is the signal of the same name.
macro_rules! trace {
    ($(#[doc = $meaning:literal] $name:ident: $value:ident, $unit:literal $(=> $read:expr)?;)*) => {
        pub const TRACE_COLUMNS: &[TraceColumn] = &[
            $(TraceColumn { name: stringify!($name), unit: $unit, meaning: $meaning.trim_ascii() },)*
        ];

        pub const COLUMNS: [&str; TRACE_COLUMNS.len()] = [$(stringify!($name)),*];

        #[derive(Debug, Clone, PartialEq)]
        pub struct Trace {
            $(#[doc = $meaning] pub $name: Vec<$value>,)*
            pub extra_parameter: Option<(&'static str, Vec<f64>)>,
            contact_m: Option<f64>,
            pub(crate) grid: TickGrid,
            ports: PortEnergies,
        }

        impl Trace {
            pub fn new(grid: TickGrid) -> Self {
                Self {
                    $($name: with_capacity(grid.ticks() as usize),)*
                    extra_parameter: None,
                    contact_m: None,
                    grid,
                    ports: PortEnergies::default(),
                }
            }

            pub fn columns(&self) -> [ColumnValues<&[f64], &[u8]>; COLUMNS.len()] {
                [$(trace!(@values $value &self.$name)),*]
            }

            pub fn take_columns(&mut self) -> [ColumnValues<Vec<f64>, Vec<u8>>; COLUMNS.len()] {
                [$(trace!(@values $value std::mem::take(&mut self.$name))),*]
            }
        }

        struct Read;

        #[allow(non_upper_case_globals, reason = "named as the columns")]
        impl Read {
            $(const $name: fn(&Signals<f64>, &TickGrid, &PortEnergies) -> $value = trace!(@read $name $($read)?);)*
        }

        impl Observer<f64> for Trace {
            fn observe(&mut self, s: &Signals<f64>) {
                self.ports.add(s);
                $(self.$name.push((Read::$name)(s, &self.grid, &self.ports));)*
                if let Some((_, extra)) = &mut self.extra_parameter {
                    extra.push(s.extra_parameter);
                }
            }
        }

        struct Ticks {
            $($name: [$value; AT_ONCE],)*
            extra_parameter: [f64; AT_ONCE],
        }

        impl Ticks {
            const NONE: Self = Self { $($name: [0 as $value; AT_ONCE],)* extra_parameter: [0.0; AT_ONCE] };
        }

        impl Observer<f64> for TraceRecorder<'_> {
            fn observe(&mut self, s: &Signals<f64>) {
                let Self { trace, ticks, count } = self;
                trace.ports.add(s);
                // Shows the compiler that the index is within the block.
                let at = *count % AT_ONCE;
                $(ticks.$name[at] = (Read::$name)(s, &trace.grid, &trace.ports);)*
                ticks.extra_parameter[at] = s.extra_parameter;
                *count = at + 1;
                if *count == AT_ONCE {
                    self.append();
                }
            }
        }

        impl TraceRecorder<'_> {
            #[inline(never)]
            fn append(&mut self) {
                let Self { trace, ticks, count } = self;
                $(trace.$name.extend_from_slice(&ticks.$name[..*count]);)*
                if let Some((_, extra)) = &mut trace.extra_parameter {
                    extra.extend_from_slice(&ticks.extra_parameter[..*count]);
                }
                *count = 0;
            }
        }
    };
    (@values f64 $values:expr) => { ColumnValues::Numbers($values) };
    (@values u8 $values:expr) => { ColumnValues::Codes($values) };
    (@read $name:ident) => { |s, _, _| s.$name };
    (@read $name:ident $read:expr) => { $read };
}

trace! {
    /// Time of the tick.
    time_s: f64, "s" => |s, grid, _| grid.time_s(s.tick);
    /// Desired position of the master, x_d.
    desired_position_m: f64, "m";
    /// Position of the master, x_h.
    master_position_m: f64, "m";
    /// Velocity of the master, v_h.
    master_velocity_m_per_s: f64, "m/s";
    /// Force of the hand on the master, F_h, positive when pushing in.
    operator_force_n: f64, "N";
    /// Commanded position of the slave, x_ref.
    slave_reference_m: f64, "m";
    /// Position of the slave, x_e, increasing into the tissue.
    slave_position_m: f64, "m";
    /// Velocity of the slave, v_e.
    slave_velocity_m_per_s: f64, "m/s";
    /// Force of the tissue on the needle, f_e, positive when it resists insertion.
    tissue_force_n: f64, "N";
    /// Measured force, y.
    measured_force_n: f64, "N";
    /// Feedback force as it arrives at the master, F_ed.
    feedback_force_n: f64, "N";
    /// Estimated stiffness, K.
    stiffness_n_per_m: f64, "N/m";
    /// Estimated damping, B.
    damping_n_s_per_m: f64, "N·s/m";
    /// Prediction error of the estimator, e.
    residual_n: f64, "N";
    /// Distance, s; its unit follows detector.distance.
    distance: f64, "N²";
    /// Decision function, g; an alarm is raised above detector.threshold.
    decision: f64, "N²";
    /// Mode of the supervisor: 0 teleoperation, 1 augmented, 2 re-engaging.
    mode: u8, "" => |s, _, _| s.mode.lane(0).code();
    /// Work of the hand on the master so far, ∫ F_h dx_h.
    hand_energy_j: f64, "J" => |_, _, ports| ports.hand_j;
    /// Work of the hand on the feedback force so far, Σ F_ed Δx_h: E_m.
    master_energy_j: f64, "J" => |_, _, ports| ports.master_j;
    /// Work of the reference on the tissue force so far, Σ f_e Δx_ref.
    reference_energy_j: f64, "J" => |_, _, ports| ports.reference_j;
    /// Work of the needle on the tissue so far, ∫ f_e dx_e: E_s.
    needle_energy_j: f64, "J" => |_, _, ports| ports.needle_j;
}

impl Trace {
    pub fn recorder(&mut self) -> TraceRecorder<'_> {
        TraceRecorder { trace: self, ticks: Ticks::NONE, count: 0 }
    }

    pub fn with_extra_parameter(mut self, column: Option<&'static str>) -> Self {
        self.extra_parameter = column.map(|name| (name, with_capacity(self.grid.ticks() as usize)));
        self
    }

    pub fn with_contact(mut self, contact_m: f64) -> Self {
        self.contact_m = Some(contact_m);
        self
    }

    /// Uses the depth of the needle, not of the sensor; `None` without the contact position.
    pub fn trust(&self) -> Option<TrustColumns> {
        let motion = (&*self.slave_position_m, &*self.slave_velocity_m_per_s);
        let parameters = (&*self.stiffness_n_per_m, &*self.damping_n_s_per_m);
        let of = |contact_m| TrustColumns::of((contact_m, self.grid.tick_s()), motion, &self.residual_n, parameters);
        self.contact_m.map(of)
    }

    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    pub fn numbers(&self) -> Vec<&[f64]> {
        let numbers = |values| match values {
            ColumnValues::Numbers(numbers) => Some(numbers),
            ColumnValues::Codes(_) => None,
        };
        self.columns().into_iter().filter_map(numbers).collect()
    }
}
