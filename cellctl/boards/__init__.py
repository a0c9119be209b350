"""The cell's own boards, on serial ports: what both of them and the host speak."""
