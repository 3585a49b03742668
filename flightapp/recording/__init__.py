"""The flight recorder: channels, writer, reader, recovery and health of recordings (MCAP)."""
