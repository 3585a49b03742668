"""Plain pictures of a campaign, for a paper or a README."""
