"""Types of the dictionaries of a run, in SI units; names end with the unit. Undefined values are ``None``."""

from __future__ import annotations

from typing import Any, Literal, TypedDict


class _Kind(TypedDict):
    kind: Literal["completed", "oscillating", "diverged"]


class Outcome(_Kind, total=False):
    """The outcome of a run: its kind, ``time_s`` of a divergence, and ``frequency_hz`` and ``swing_m`` of an oscillation."""

    time_s: float
    frequency_hz: float
    swing_m: float


class Alarm(TypedDict):
    """An accepted alarm: its time in s, and true if it is the first one of a rupture."""

    time_s: float
    matched: bool


class ModeTimes(TypedDict):
    """The time in each mode, in s."""

    teleoperation_s: float
    augmented_s: float
    reengaging_s: float


class Rupture(TypedDict):
    """A rupture of a layer."""

    # Time at which the layer ruptured.
    time_s: float
    # Name of the layer; `None` for a tissue without layers, or if the run is not recorded tick by tick.
    layer: str | None
    # Advance of the needle 0.3 s after the rupture; negative if it moved back.
    slave_travel_m: float | None
    # Advance of the needle beyond the intended motion 0.3 s after the rupture; undefined if the intended motion
    # is unknown.
    unintended_travel_m: float | None
    # Largest advance of the needle before the next rupture, within 2 s.
    deepest_advance_m: float | None
    # Largest advance of the needle beyond the intended motion before the next rupture, within 2 s; undefined if
    # the intended motion is unknown.
    excess_advance_m: float | None
    # Time from the rupture to the return to teleoperation; undefined without an event.
    return_after_s: float | None
    # Advance of the needle from its release to the return to teleoperation; undefined without an event.
    return_jump_m: float | None
    # Advance of the needle at the next rupture, or after 2 s.
    horizon_advance_m: float | None
    # Largest force on the hand from the rupture to 0.3 s after it.
    felt_peak_n: float | None
    # Largest fall of the force on the hand from an earlier value, from the rupture to 0.3 s after it.
    felt_drop_n: float | None
    # 1 if the operator noticed the rupture before the next one and within 2 s, else 0; undefined for an
    # operator who cannot notice ruptures.
    noticed: int | None
    # Time from the rupture to its alarm, at most 0.1 s and after a fall of the force; undefined if the rupture
    # was missed.
    detection_delay_s: float | None
    # Advance of the needle from the rupture to the return to teleoperation; undefined without an event.
    depth_at_return_m: float | None
    # Largest depth of the needle beyond the largest intended depth before the next rupture, within 2 s.
    unintended_cut_m: float | None
    # Time from the rupture until the operator noticed it.
    noticed_after_s: float | None
    # Why the rupture was missed; `None` if it was not missed, or if the run is not recorded tick by tick.
    miss: dict[str, Any] | None
    # Maximum advance of the needle in the 0.5 s after the rupture.
    slave_overshoot_m: float | None
    # Velocity of the master at the rupture.
    master_velocity_m_per_s: float
    # Position of the master at the rupture.
    master_position_m: float
    # Maximum advance of the master in the 0.5 s after the rupture.
    master_travel_m: float | None
    # Time until the feedback force has fallen to 5 % of its value at the rupture; undefined if it has not
    # within 0.5 s.
    feedback_fall_s: float | None
    # Time until the force on the hand has fallen to 5 % of its value at the rupture; undefined if it has not
    # within 0.5 s.
    felt_fall_s: float | None
    # Maximum rate of change of the force on the hand in the 0.5 s after the rupture.
    peak_force_rate_n_per_s: float | None
    # Largest drop of the force on the hand within 0.3 s, relative to its value at the rupture; above 100 % the
    # force pulls the hand.
    felt_contrast: float | None


class Event(TypedDict):
    """An augmented event, from the alarm to the return to teleoperation."""

    # Time at which the alarm was accepted.
    start_s: float
    # Time from the start to the release of the slave; undefined if the run ended before the release.
    augmented_s: float | None
    # Duration of re-engaging; undefined if the run ended before the return to teleoperation.
    reengaging_s: float | None
    # Position of the master at the start.
    master_start_m: float
    # Position of the master when the slave was released, or at the last tick of a run that ended before the
    # release.
    master_end_m: float
    # Maximum distance of the slave from its position at the start, up to its release.
    frozen_motion_m: float
    # Maximum speed of the slave while re-engaging; undefined if it did not re-engage.
    peak_reengaging_speed_m_per_s: float | None
    # 1 if the event began with a false alarm, else 0.
    is_false: int
    # Largest change of the feedback force from its value at the start.
    force_change_n: float
    # Advance of the needle beyond the intended motion from the start to the return to teleoperation.
    excess_at_return_m: float | None
    # 1 if the operator noticed a change of the felt force within 2 s of the start, else 0.
    noticed: int | None
    # Change of the feedback force in the first tick of the event.
    entry_step_n: float
    # Change of the feedback force that its force law allows in the first tick of the event.
    entry_step_allowed_n: float
    # Change of the feedback force in the first tick of re-engaging.
    exit_step_n: float | None
    # Change of the feedback force that its force law allows in the first tick of re-engaging.
    exit_step_allowed_n: float | None


class LinkMetrics(TypedDict):
    """The metrics of a link that does not pass everything on in the same tick."""

    # Number of outages of the link, in either direction.
    outages: int
    # Duration of the longest outage.
    longest_outage_s: float
    # Time at which the slave stopped following the link.
    given_up_s: float | None
    # Work of the master on the link, ∫ F_ed dx_h.
    master_port_energy_j: float
    # Work of the needle on the tissue by the measured force, ∫ f_e dx_e.
    slave_port_energy_j: float
    # Largest energy delivered by both ports beyond the energy received, max(E_s - E_m), by the measured force.
    generated_energy_j: float
    # Upper bound of the generated energy that the passivity scheme guarantees.
    promised_energy_j: float | None
    # Distance by which the slave is deeper than the hand at the last tick.
    left_behind_m: float
    # Energy that the passivity controller dissipated at the master.
    master_dissipated_j: float
    # Work that the passivity controller withheld from the slave.
    slave_refused_j: float


class PortMetrics(TypedDict):
    """The energies at the ports of the teleoperator."""

    # Work of the hand on the master, ∫ F_h dx_h.
    hand_energy_j: float
    # Work of the hand on the feedback force, E_m = Σ F_ed Δx_h.
    master_energy_j: float
    # Work of the reference on the tissue force, Σ f_e Δx_ref.
    reference_energy_j: float
    # Work of the needle on the tissue, E_s = ∫ f_e dx_e.
    needle_energy_j: float
    # Largest energy that the master has delivered beyond the energy it has received.
    master_generated_j: float
    # Largest energy that the master has stored and delivered later.
    master_stored_j: float
    # Energy that the master has retained at the end: dissipated, or still stored.
    master_kept_j: float
    # Largest energy that the link has delivered beyond the energy it has received.
    link_generated_j: float
    # Largest energy that the link has stored and delivered later.
    link_stored_j: float
    # Energy that the link has retained at the end: dissipated, or still stored.
    link_kept_j: float
    # Largest energy that the slave has delivered beyond the energy it has received.
    slave_generated_j: float
    # Largest energy that the slave has stored and delivered later.
    slave_stored_j: float
    # Energy that the slave has retained at the end: dissipated, or still stored.
    slave_kept_j: float
    # Largest energy delivered at the ports of hand and needle beyond the energy received, max(E_s - E_m).
    generated_j: float
    # Time of the largest energy generated between hand and needle.
    generated_at_s: float
    # Position of the needle at the time of the largest energy generated between hand and needle.
    generated_at_m: float


class Metrics(TypedDict):
    """All metrics of a run."""

    # The outcome of the run.
    outcome: Outcome
    # Number of ticks of the run.
    ticks: int
    # One entry per rupture, in time order.
    ruptures: list[Rupture]
    # One entry per augmented event, in time order.
    events: list[Event]
    # The accepted alarms, in time order (the first 4096).
    alarms: list[Alarm]
    # Ruptures without an alarm within 0.1 s.
    missed_ruptures: int
    # Ruptures without an alarm, less than 0.1 s before the end of the run.
    undecided_ruptures: int
    # Alarms without a rupture, or for a rupture that already had an alarm.
    false_alarms: int
    # Alarms ignored because an event was in progress or had just ended.
    ignored_alarms: int
    # Advance of the needle beyond the intended position at the last time at which the intended position was
    # deepest, the end of the insertion.
    final_excess_m: float | None
    # Changes of the felt force noticed without a rupture or an event in the 2 s before, while the operator does
    # not withdraw.
    false_notices: int | None
    # Time without withdrawal outside the 2 s after ruptures and accepted alarms; undefined if the intended
    # motion is unknown.
    undisturbed_s: float | None
    # Mean of the absolute residual of the estimator, over the run.
    mean_absolute_residual_n: float | None
    # Minimum tissue force on the needle; negative where it resists withdrawal.
    min_tissue_force_n: float | None
    # Maximum tissue force on the needle, positive where it resists insertion.
    max_tissue_force_n: float | None
    # Root mean square of the slave's distance from its reference, in teleoperation.
    tracking_rmse_m: float | None
    # Position of the slave at the last tick.
    final_slave_position_m: float | None
    # Distance of the slave from its reference at the last tick, relative to the reference: (x_ref - x_e) /
    # x_ref.
    final_tracking_error: float | None
    # Maximum speed of the slave while re-engaging, over all events.
    peak_reengaging_speed_m_per_s: float | None
    # Maximum change of the feedback force in one tick of an event beyond what its law allows; 0 apart from
    # rounding.
    feedback_step_excess_n: float
    # Time per mode.
    mode_times: ModeTimes
    # Number of changes of mode.
    mode_switches: int
    # Work of the hand on the master, ∫ F_h v_h dt.
    operator_energy_j: float | None
    # Work of the needle on the tissue, ∫ f_e v_e dt.
    tissue_energy_j: float | None
    # The link's metrics; `None` for a direct link.
    link: LinkMetrics | None
    # The energies at the ports. Reported only for runs with a trace.
    ports: PortMetrics | None

