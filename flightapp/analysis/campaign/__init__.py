"""Campaigns: planners on the same seeds of one scenario, compared with statistics, tables and pictures."""
