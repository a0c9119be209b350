"""The service: what the service manager is told, its units, installing, keeping a copy."""
