"""The cell in three dimensions: what a page's 3D view gets to know, and the view itself."""
