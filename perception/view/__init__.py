"""What perception sees, shown to a person: pictures, video, a web page, tables, JSON Lines."""
