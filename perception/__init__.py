"""From depth frames to obstacle discs. Imports nothing of flightapp."""
