"""Every number of the AC2F planner, with its unit.

Defaults are the source's Table 1 where it has one, but for the weights, which are those that `flightapp tune` found; the
source's own are in missions/parameters/ac2f-paper.toml.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from flightapp.planning.ac2f.volume.parameters import VolumeParameters
from flightapp.planning.capture import CaptureRule
from flightapp.planning.parameters import StrategyParameters


class Ac2fParameters(StrategyParameters):
    """Parameters of the strategy `ac2f`. Vehicle limits are not among them: they come with `limits`."""

    capture: CaptureRule = CaptureRule()
    """The mission's capture section."""
    evader_speed_assumed_m_s: float = Field(default=4.0, gt=0)
    """Top speed of the evader in the game."""
    volume: VolumeParameters = VolumeParameters()
    """Flight up and down to the evader; off by default. Not part of the kernels' record."""

    # what the planner is made of: the named variants are choices here
    stages: Literal["both", "coarse", "fine"] = "both"
    """Coarse and fine; `coarse`: never fine, the capture condition leads to tracking at once; `fine`: always fine while the
    target is fresh, without time limit, trap trigger and tracking."""
    goal: Literal["game", "evader"] = "game"
    """Far from the evader: to the game point on Apollonius circles, or to the evader's present position."""
    game: Literal["intersection", "union"] = "intersection"
    """The region whose point nearest to the boundary is the game point; `union` is the source's literal reading."""
    lead: bool = True
    """Aim at the intercept of the evader's predicted motion, and at a slot around it; False: at its present position."""
    avoidance: Literal["search", "field", "adaptive"] = "search"
    """Coarse stage: the velocity nearest to the deflected wish that can brake before every disc; the plain potential field
    with the speed limited by what can be braked before the first obstacle ahead (the source's form); or as `search`, the wish
    being deflected by the forces of the strategy `adaptive-apf`."""
    admissibility: bool = True
    """Fine stage: an arc is allowed only if braking along it stays free of collision, too."""
    terminal_adaptation: bool = True
    """Below the fine distance: heading and velocity weights swapped, short horizon."""

    # state machine
    fine_distance_m: float = Field(default=4.0, gt=0)
    """Fine stage below this distance to the evader."""
    fine_hysteresis_m: float = Field(default=0.5, ge=0)
    """Fine stage is left above the trigger distance plus this."""
    oscillation_window_s: float = Field(default=2.0, gt=0)
    """Length of the window of own positions whose variance tells a trap."""
    oscillation_variance_m2: float = Field(default=0.08, gt=0)
    """Trapped below this trace of the position covariance."""
    fine_time_max_s: float = Field(default=3.0, gt=0)
    """Longest stay in the fine stage."""
    fine_pause_s: float = Field(default=1.0, ge=0)
    """After the longest stay, the distance does not trigger again for this long."""
    target_stale_s: float = Field(default=2.0, gt=0)
    """Age of the target track from which the last predicted point is searched."""
    target_lost_s: float = Field(default=10.0, gt=0)
    """Age of the target track from which the vehicle holds."""
    team_stale_s: float = Field(default=2.0, gt=0)
    """Age of a teammate's state from which it no longer counts for encirclement and slots."""

    # dynamic window
    control_period_s: float = Field(default=0.1, gt=0)
    """Period of the dynamic window and of the samples in the history."""
    command_blend: float = Field(default=0.08, ge=0, le=1)
    """Centre of the window: this share of the measured velocity, the rest of the last command."""
    horizon_s: float = Field(default=1.0, gt=0)
    """Prediction horizon on the approach."""
    horizon_terminal_s: float = Field(default=0.2, gt=0)
    """Prediction horizon below the fine distance."""
    speed_samples: int = Field(default=21, ge=2, le=101)
    """Speeds in the window."""
    turn_samples: int = Field(default=21, ge=2, le=101)
    """Turn rates in the window."""
    braking_steps: int = Field(default=6, ge=1, le=50)
    """Segments of the braking arc after the horizon."""
    clearance_saturation_m: float = Field(default=2.0, gt=0)
    """Clearance above this is as good as this."""
    rejection_radius_m: float = Field(default=0.5, ge=0)
    """Smallest distance of the own centre from an obstacle's surface; at least body radius plus safety margin is kept."""
    history_samples: int = Field(default=30, ge=2, le=300)
    """Own positions kept for the memory penalty."""
    memory_scale_m: float = Field(default=0.5, gt=0)
    """Width of the memory kernel."""
    memory_weight: float = Field(default=0.15, ge=0)
    """Weight of the memory penalty after an oscillation trigger."""
    memory_release_m: float = Field(default=3.0, gt=0)
    """The memory penalty ends this far from where the oscillation was noticed."""
    weight_heading: float = Field(default=0.280, ge=0)
    """alpha at or above the fine distance; swapped with gamma below it."""
    weight_clearance: float = Field(default=0.308, ge=0)
    """beta."""
    weight_velocity: float = Field(default=0.412, ge=0)
    """gamma at or above the fine distance; swapped with alpha below it."""
    aim: Literal["wish", "goal"] = "wish"
    """Headings are judged against a place in the direction of the wish that no arc passes within the horizon, or against the
    goal itself (the source's form): arcs that pass it point away from it, so a vehicle that near slows down and trails."""
    aim_distance_m: float = Field(default=3.0, gt=0)
    """The place in the direction of the wish is this far beyond what is reached within the horizon at top speed."""
    standing_speed_m_s: float = Field(default=0.3, ge=0)
    """Below this speed the course is the nose's, or any near the evader; a search has arrived."""
    search_turn_rad: float = Field(default=0.5, gt=0)
    """Turning at the place of a search, per decision."""
    no_admissible: Literal["evade", "brake"] = "evade"
    """Where no arc is admissible, moving: the velocity of the reactive avoidance, or braking along the present arc (the source's
    form). Standing, the nose turns to the widest free gap in both."""
    raw_scores: bool = False
    """True: weights act on the plain scores (the source's literal form)."""

    # reactive avoidance
    field_gain_m2: float = Field(default=0.25, ge=0)
    """eta: repulsion, relative to an attraction of 1, at 1 m from the inflated edge."""
    field_influence_m: float = Field(default=2.5, gt=0)
    """Distance from the inflated edge within which an obstacle repels."""
    field_repulsion_max: float = Field(default=0.9, ge=0)
    """Cap of the summed repulsion, relative to an attraction of 1."""
    braking_share: float = Field(default=0.8, gt=0, le=1)
    """Share of the vehicle's acceleration limit that braking may assume."""
    reaction_s: float = Field(default=0.55, ge=0)
    """Time from a decision until the vehicle brakes: its lag plus the age of what it sees."""
    response_lag_s: float = Field(default=0.45, ge=0)
    """Lag of the velocity loop; motions are judged from where this lag puts the vehicle."""
    repelling_gap_min_m: float = Field(default=0.1, gt=0)
    """Nearer to an inflated edge than this the repulsion does not grow."""
    manoeuvre_s: float = Field(default=0.2, ge=0)
    """A velocity is judged by what this long a change reaches of it, too."""
    leaving_gain_per_s: float = Field(default=2.0, ge=0)
    """Speed out of a disc in whose inflation the vehicle is, per metre of depth."""
    leaving_speed_max_m_s: float = Field(default=1.0, ge=0)
    """Highest speed that leaving an inflation asks for."""
    excess_cost: float = Field(default=8.0, gt=0)
    """Cost of 1 m/s too fast to stop, where 1 m/s less along the wish costs 1."""
    reached_excess_cost: float = Field(default=1000.0, gt=0)
    """The same for what is reached of a velocity within the manoeuvre: paid only where nothing that can be reached is safe."""
    across_cost: float = Field(default=0.3, ge=0)
    """Cost of 1 m/s across the wish."""
    change_cost: float = Field(default=0.1, ge=0)
    """Cost of 1 m/s of change from the present velocity, against chatter."""
    obstacle_range_m: float = Field(default=15.0, gt=0)
    """Obstacles beyond are ignored."""
    leave_first_m: float = Field(default=0.1, ge=0)
    """Deeper than this inside the margin of an obstacle, leaving it comes before everything, in the fine stage, too."""
    unseen_speed_m_s: float = Field(default=1.5, gt=0)
    """Speed limit into a sector that was not observed."""

    # target and team
    prediction_max_s: float = Field(default=1.0, ge=0)
    """Older states of teammates and evader are moved on with their velocity over no more than this."""
    slot_range_m: float = Field(default=12.0, gt=0)
    """Within this distance of the evader the goal is the own slot around it."""
    lead_range_m: float = Field(default=25.0, gt=0)
    """Between this distance and the slot range the goal moves from the game point to the intercept of the predicted motion."""
    goal_spacing_m: float = Field(default=3.0, gt=0)
    """Distance from the game point of the goals of pursuers that are not active there."""
    goal_spread_m: float = Field(default=4.0, ge=0)
    """Each of several pursuers aims this far beside the game point, towards its own slot, so that they do not converge."""
    slot_gain_per_s: float = Field(default=1.5, gt=0)
    """Approach speed to the slot per metre of way left."""
    slot_braking_share: float = Field(default=0.5, gt=0, le=1)
    """Share of the acceleration limit that the approach to the slot plans with."""
    slot_look_ahead_s: float = Field(default=0.3, ge=0)
    """A slot is kept free of obstacles where the evader will be after this time."""
    slot_clearance_m: float = Field(default=0.3, ge=0)
    """A slot this far from every inflated edge is free."""
    slot_spare_deg: float = Field(default=5.0, ge=0)
    """A slot that is not free moves by at most what the encirclement allows, less this."""
    slot_leave_share: float = Field(default=0.2, ge=0, le=1)
    """Within the evader's keep-out the way to the slot leads outwards by this share of the speed, the rest of it around."""
    slot_leave_gain: float = Field(default=2.0, ge=0)
    """And by this much more per depth in the keep-out, as a share of the keep-out."""
    contact_closing_m_s: float = Field(default=1.5, ge=0)
    """Where the first contact ends it: closing speed with which the evader is met when it is caught up with."""
    contact_braking_share: float = Field(default=0.3, gt=0, le=1)
    """Share of the acceleration limit with which the closing speed comes down to that one: what is left steers."""
    contact: Literal["at-once", "encircled"] = "at-once"
    """Where the first contact ends it: the evader is met as soon as it can be, or by three and more pursuers only once it is
    inside their hull; until then each flies to its slot at `flank_radius_m`."""
    flank_radius_m: float = Field(default=3.0, gt=0)
    """Where the first contact ends it: all but the pursuer that arrives first wait for a miss this far beside the evader."""
    flank_tie_s: float = Field(default=0.15, ge=0)
    """Arrivals nearer than this to each other are as good as equal: the pursuer further south goes first."""
    evader_keep_out_m: float = Field(default=1.5, ge=0)
    """Smallest distance from the evader, where the hold radius is larger than this; otherwise contact is allowed."""
    evader_path_margin_m: float = Field(default=0.3, ge=0)
    """Ways around the evader keep this much more."""
    team_separation_m: float = Field(default=2.2, gt=0)
    """Smallest distance from a teammate, centre to centre; less only where the hold radius demands it. The sum of
    separation_min_m, separation_buffer_m and separation_passing_m of the supervisor, which then has nothing to add."""
    team_body_gap_m: float = Field(default=0.05, ge=0)
    """And never less than two body radii and this."""
    team_chord_share: float = Field(default=0.95, gt=0, le=1)
    """What the hold radius demands, as a share of the distance of neighbouring slots."""
    vehicle_disc_m: float = Field(default=0.25, ge=0)
    """A disc whose surface is this near to where another vehicle's centre is or was within the trail is that vehicle: less than
    a body radius, so that no obstacle can be there."""
    vehicle_radius_max_m: float = Field(default=0.6, ge=0)
    """Discs larger than this are never taken for a vehicle."""
    vehicle_trail_s: float = Field(default=2.0, ge=0)
    """Length of the trail of other vehicles."""
    arrival_window_s: float = Field(default=1.0, gt=0)
    """Pursuers arrive within this window."""
    arrival_slowdown_min: float = Field(default=0.6, gt=0, le=1)
    """An early pursuer keeps at least this share of its speed."""
    arrival_margin_m: float = Field(default=8.0, ge=0)
    """Early pursuers slow down only while the game point is this far from the boundary."""
    face_evader_speed_m_s: float = Field(default=0.5, ge=0)
    """Below this speed, within the slot range, the vehicle faces the evader; above it, its direction of travel."""

    # discs that left the view, and the way out of traps
    disc_memory_s: float = Field(default=10.0, ge=0)
    """How long a static disc that is no longer seen is still avoided and planned around; 0: not at all."""
    disc_memory_gate_m: float = Field(default=0.35, gt=0, le=1)
    """A disc is the remembered one if the centres are within this distance."""
    disc_memory_sight_m: float = Field(default=5.0, ge=0)
    """Within this distance a remembered disc that one looks through is forgotten: less than any sensor's range."""
    disc_memory_speed_max_m_s: float = Field(default=0.3, ge=0)
    """Faster discs are not remembered."""
    guidance: bool = True
    """Fly around traps by guidance points: the corners of the shortest way past the remembered discs."""
    guidance_group_m: float = Field(default=3.0, gt=0)
    """A way is only searched where a group of discs without a gap to pass reaches this far from its disc in the straight way."""
    guidance_detour_m: float = Field(default=2.0, gt=0)
    """Guided where the way past the discs is longer than the straight one by this; until it is by a quarter of this."""
    guidance_margin_m: float = Field(default=0.3, ge=0)
    """The way keeps this much more from discs where there is room."""
    guidance_cell_m: float = Field(default=0.5, gt=0.1, le=2)
    """Side of a cell of the search, which covers 128 x 128 of them around the vehicle."""
    guidance_period_s: float = Field(default=0.5, gt=0)
    """Shortest time between two searches."""
    guidance_time_max_s: float = Field(default=20.0, gt=0)
    """Longest time of being guided at a stretch."""
    guidance_pause_s: float = Field(default=2.0, ge=0)
    """After it, or where no way was found, this long without."""

    @model_validator(mode="after")
    def _is_consistent(self) -> Ac2fParameters:
        if self.target_lost_s <= self.target_stale_s:
            raise ValueError(f"target_lost_s = {self.target_lost_s} must be greater than target_stale_s = {self.target_stale_s}")
        if self.lead_range_m <= self.slot_range_m:
            raise ValueError(f"lead_range_m = {self.lead_range_m} must be greater than slot_range_m = {self.slot_range_m}")
        if self.weight_heading + self.weight_clearance + self.weight_velocity <= 0.0:
            raise ValueError("weight_heading, weight_clearance and weight_velocity are all 0; at least one must be positive")
        return self

    @property
    def fine_trigger_m(self) -> float:
        """The fine distance, never inside the capture radius: the fine stage must come before the capture."""
        return max(self.fine_distance_m, self.capture.radius_m + self.fine_hysteresis_m)
