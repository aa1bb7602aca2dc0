"""Materials of the products, and how a part gets one."""

STEEL, GOLD, COPPER, BRASS = (0.82, 0.82, 0.83), (1.0, 0.77, 0.34), (0.96, 0.62, 0.5), (0.9, 0.75, 0.45)


def part(scene, material, surface, **members):
    scene.node(mesh=scene.mesh(material, *surface), **members)


def extended(scene, surface, **extensions):
    """A material with extensions, by the second half of their names."""
    members = {}
    for name, values in extensions.items():
        members.update(scene.use("KHR_materials_" + name, values))
    return scene.material(**surface, extensions=members)


def coated(scene, color, roughness=0.5, coat=0.03, **members):
    return extended(scene, {"color": color, "roughness": roughness, **members}, clearcoat={
        "clearcoatFactor": 1, "clearcoatRoughnessFactor": coat})


def metal(scene, color, roughness, **extensions):
    return extended(scene, {"color": color, "metallic": 1, "roughness": roughness}, **extensions)


def brushed(scene, color=(0.86, 0.85, 0.83), roughness=0.32):
    return metal(scene, color, roughness, anisotropy={"anisotropyStrength": 0.75})
