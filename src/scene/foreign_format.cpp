#include "scene/foreign_format.h"

#include "core/files.h"

#include <fmt/format.h>

#include <string_view>

namespace sightline {
namespace {

constexpr const char* blender = "Blender (File > Import, then File > Export > glTF 2.0)";

struct ForeignFormat {
    std::string_view extension;
    std::string_view begin;  ///< of every such file; empty: not recognised by content
    const char* name;
    const char* converter;
};

constexpr ForeignFormat formats[] = {
    {".obj", "", "Wavefront OBJ", blender},
    {".mtl", "newmtl ", "a material library of Wavefront OBJ", blender},
    {".fbx", "Kaydara FBX Binary", "FBX", "FBX2glTF or Blender"},
    {".fbx", "; FBX ", "FBX", "FBX2glTF or Blender"},
    {".usdz", "", "USDZ", blender},
    {".usdc", "PXR-USDC", "USD", blender},
    {".usda", "#usda ", "USD", blender},
    {".usd", "", "USD", blender},
    {".stl", "solid ", "STL", blender},
    {".ply", "ply\n", "PLY", blender},
    {".ply", "ply\r\n", "PLY", blender},
    {".blend", "BLENDER", "a Blender file", "Blender (File > Export > glTF 2.0)"},
    {".dae", "", "COLLADA", "COLLADA2GLTF or Blender"},
    {".3ds", "", "3D Studio", blender},
    {".max", "", "a 3ds Max file", "3ds Max with the Babylon.js exporter"},
    {".ma", "//Maya ASCII", "a Maya file", "Maya with the Babylon.js exporter"},
    {".mb", "", "a Maya file", "Maya with the Babylon.js exporter"},
    {".c4d", "", "a Cinema 4D file", "Cinema 4D (File > Export > glTF)"},
    {".abc", "Ogawa", "Alembic", blender},
    {".x3d", "", "X3D", blender},
    {".wrl", "#VRML", "VRML", blender},
    {".3mf", "", "3MF", "Blender with an importer of 3MF"},
    {".step", "ISO-10303-21", "STEP", "FreeCAD (File > Export > glTF)"},
    {".stp", "", "STEP", "FreeCAD (File > Export > glTF)"},
    {".iges", "", "IGES", "FreeCAD (File > Export > glTF)"},
    {".b3dm", "b3dm", "a tile of 3D Tiles", "3d-tiles-tools (b3dmToGlb)"},
};

std::string describe(const ForeignFormat& format) {
    return fmt::format("is {}; only glTF is read, .gltf or .glb; to convert it: {}", format.name,
                       format.converter);
}

}  // namespace

std::string describe_foreign_format(const std::string& path, std::span<const std::byte> begin) {
    const std::string_view text(reinterpret_cast<const char*>(begin.data()), begin.size());
    for (const ForeignFormat& format : formats)
        if (!format.begin.empty() && text.starts_with(format.begin)) return describe(format);
    const std::string extension = extension_of(path);
    for (const ForeignFormat& format : formats)
        if (extension == format.extension) return describe(format);
    return {};
}

}  // namespace sightline
