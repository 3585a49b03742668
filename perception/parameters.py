"""Parameters of the way from a depth frame to discs, as they stand in a profile under [perception]."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class PerceptionParameters(BaseModel):
    """Extraction and short-term memory."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    stride_px: int = Field(default=2, ge=1, le=8)
    """Every how many rows and columns a depth pixel is used."""
