"""Request -> mesh: one Protocol, several generators."""
