"""Words -> what is wanted: one Protocol, and the back ends that keep it."""
