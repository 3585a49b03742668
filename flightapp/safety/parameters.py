"""Parameters of the supervisor's guards, as they stand in a profile under [safety]."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class SafetyParameters(BaseModel):
    """Margins and time limits of the guards."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    separation_min_m: float = Field(default=1.5, gt=0)
    """Smallest distance between the centres of two vehicles of the fleet."""
    target_keep_out_m: float = Field(default=1.2, ge=0)
    """Smallest distance between the own centre and the evader's; 0 allows contact."""
    own_state_age_max_s: float = Field(default=0.3, gt=0)
    team_state_age_max_s: float = Field(default=1.0, gt=0)
    obstacles_age_max_s: float = Field(default=0.5, gt=0)
