"""The wind of harmonics and a gust step, as mission and scenario files describe it; `flightapp.sim.wind` makes it blow."""

from __future__ import annotations

from pydantic import Field, model_validator

from flightapp.config.loading import Strict

Triple = tuple[float, float, float]
HARMONICS_MAX = 8


class HarmonicWind(Strict):
    """Where the air moves to; an empty table takes the defaults."""

    amplitudes_horizontal_m_s: tuple[float, ...] = (1.5, 0.8, 0.4)
    """Of each harmonic, north and east."""
    amplitudes_vertical_m_s: tuple[float, ...] = (0.5, 0.3, 0.15)
    frequencies_rad_s: tuple[float, ...] = (0.4, 1.1, 2.7)
    step_ned_m_s: Triple = (3.0, 2.0, -0.5)
    """A gust that begins at `step_at_s` and stays."""
    step_at_s: float = Field(default=5.0, ge=0)
    """On the simulator's clock, which a mission's mock autopilots start before take-off."""
    height_gain: float = Field(default=0.5, ge=0)
    """How much stronger it is at `height_reference_m` than on the ground."""
    height_reference_m: float = Field(default=50.0, gt=0)

    @model_validator(mode="after")
    def _has_an_amplitude_for_each_frequency(self) -> HarmonicWind:
        count = len(self.frequencies_rad_s)
        if count > HARMONICS_MAX:
            raise ValueError(f"frequencies_rad_s: {count} of them; at most {HARMONICS_MAX}")
        for name in ("amplitudes_horizontal_m_s", "amplitudes_vertical_m_s"):
            if len(getattr(self, name)) != count:
                raise ValueError(f"{name}: {len(getattr(self, name))} values; one for each of the {count} frequencies_rad_s")
        return self
