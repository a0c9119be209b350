"""Parts and plans as something to look at: their form, their order, a scene, a GLB."""
