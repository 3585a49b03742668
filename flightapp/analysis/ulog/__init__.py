"""The autopilot's own logs (PX4, `.ulg`): what they say of a flight, alone (`report`) or beside our recordings (`beside`)."""
