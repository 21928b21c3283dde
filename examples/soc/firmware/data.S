/* The scene, as `raypath scene` writes it, and the rays: 7 words each, of origin, direction and extent. */
	.section .rays, "a"
	.balign 4
	.global rays, rays_end
rays:	.incbin "rays.bin"
rays_end:

	.section .scene, "aw"
	.global scene, scene_end
scene:	.incbin "scene.bin"
	.balign 128
scene_end:
