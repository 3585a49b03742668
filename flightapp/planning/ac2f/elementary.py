"""Sine, cosine and angle in plain arithmetic without branches, so that loops run over several candidates at a time.

The library's functions are hardly more exact, but a loop that calls them takes one candidate after the other.
"""

from __future__ import annotations

import math

from flightapp.core.compiled import compiled

ROUNDING = 6755399441055744.0  # 1.5 * 2^52: adding and subtracting it rounds to the nearest whole number
PI_HIGH = 3.141592653589793
PI_LOW = 1.2246467991473532e-16
TAN_PI_8 = 0.41421356237309503

# 1 / k! with alternating signs
S3, S5, S7, S9, S11 = -1 / 6, 1 / 120, -1 / 5040, 1 / 362880, -1 / 39916800
S13, S15, S17, S19, S21 = (
    1 / 6227020800,
    -1 / 1307674368000,
    1 / 355687428096000,
    -1 / 121645100408832000,
    1 / 5.109094217170944e19,
)
C2, C4, C6, C8, C10 = -1 / 2, 1 / 24, -1 / 720, 1 / 40320, -1 / 3628800
C12, C14, C16, C18, C20 = 1 / 479001600, -1 / 87178291200, 1 / 20922789888000, -1 / 6402373705728000, 1 / 2432902008176640000

# rational approximation of the arc tangent up to tan(pi / 8), from the Cephes library
P0, P1, P2, P3, P4 = (
    -8.750608600031904122785e-1,
    -1.615753718733365076637e1,
    -7.500855792314704667340e1,
    -1.228866684490136173410e2,
    -6.485021904942025371773e1,
)
Q0, Q1, Q2, Q3, Q4 = (
    2.485846490142306297962e1,
    1.650270098316988542046e2,
    4.328810604912902668951e2,
    4.853903996359136964868e2,
    1.945506571482613964425e2,
)


@compiled("UniTuple(f8,2)(f8)")
def sin_cos(x: float) -> tuple[float, float]:
    """Sine and cosine of `x` (rad, at most 1e5) within 1e-15: Taylor series on half a turn."""
    half_turns = (x * (1.0 / math.pi) + ROUNDING) - ROUNDING
    r = (x - half_turns * PI_HIGH) - half_turns * PI_LOW
    odd = half_turns - 2.0 * ((0.5 * half_turns + ROUNDING) - ROUNDING)
    sign = 1.0 - 2.0 * (odd * odd)
    z = r * r
    sine = S13 + z * (S15 + z * (S17 + z * (S19 + z * S21)))
    sine = 1.0 + z * (S3 + z * (S5 + z * (S7 + z * (S9 + z * (S11 + z * sine)))))
    cosine = C12 + z * (C14 + z * (C16 + z * (C18 + z * C20)))
    cosine = 1.0 + z * (C2 + z * (C4 + z * (C6 + z * (C8 + z * (C10 + z * cosine)))))
    return sign * r * sine, sign * cosine


@compiled("f8(f8,f8)")
def angle(across: float, along: float) -> float:
    """atan2(across, along) for across >= 0, within 1e-15; 0 where both are 0."""
    x = abs(along)
    low = across if across < x else x
    high = x if across < x else across
    big = low > TAN_PI_8 * high
    above = low - high if big else low
    below = low + high if big else high
    t = above / (below if below > 0.0 else 1.0)
    z = t * t
    top = P4 + z * (P3 + z * (P2 + z * (P1 + z * P0)))
    bottom = Q4 + z * (Q3 + z * (Q2 + z * (Q1 + z * (Q0 + z))))
    turned = t + t * (z * top / bottom)
    turned = turned + 0.25 * math.pi if big else turned
    turned = 0.5 * math.pi - turned if across > x else turned
    return math.pi - turned if along < 0.0 else turned
