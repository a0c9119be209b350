"""Mesh -> build plan: voxelise, check, repair, order."""
