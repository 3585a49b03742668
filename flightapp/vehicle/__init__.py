"""The boundary to the autopilot: the only room that knows MAVSDK, local origins and degrees."""
