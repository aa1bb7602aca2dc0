// Damage below the level of glTF: URIs, containers, JSON.
#include "support/gltf.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

namespace sightline {
namespace {

using nlohmann::json;

TEST(GltfBadFile, UrisMayNotLeaveTheFilesFolder) {
    const auto folder = test_folder();
    std::filesystem::create_directories(folder / "inside");
    const std::string outside = write_file(folder / "outside.bin", std::string(36, '\0'));
    std::filesystem::create_symlink("../outside.bin", folder / "inside" / "link.bin");
    GltfBuilder file;
    file.triangle();
    for (const std::string& uri :
         {std::string("../outside.bin"), std::string("%2e%2e/outside.bin"),
          std::string("..%2Foutside.bin"), std::string("x/../../outside.bin"),
          std::string("link.bin"), outside, "/" + outside}) {
        SCOPED_TRACE(uri);
        file.json["buffers"] = {{{"byteLength", 36}, {"uri", uri}}};
        std::filesystem::create_directories(folder / "inside" / "x");
        const std::string path = write_file(folder / "inside" / "test.gltf", file.json.dump());
        EXPECT_TRUE(fails(path, "buffers[0].uri: '" + uri + "' is outside the file's folder"));
        LoadOptions options;
        options.allow_outside = true;
        EXPECT_EQ(load_gltf(path, options).meshes.size(), 1u);
    }
}

TEST(GltfBadFile, UrisOfMissingOrIrregularFilesAreRejected) {
    const auto folder = test_folder();
    ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
    GltfBuilder file;
    file.triangle();
    for (const char* uri :
         {"http://localhost/a.bin", "file:///etc/passwd", "missing.bin", ".", "", "%", "%zz",
          "a%00b", "pipe", "data:", "data:;base64,A", "data:;base64,!!!!", "data:,short",
          "data:application/octet-stream;base64,AAAA"}) {
        SCOPED_TRACE(uri);
        file.json["buffers"] = {{{"byteLength", 36}, {"uri", uri}}};
        EXPECT_TRUE(fails(write_file(folder / "test.gltf", file.json.dump()), "buffers[0]"));
    }
}

TEST(GltfBadFile, TruncatedGlbsAreRejectedAtEveryByte) {
    GltfBuilder file;
    file.triangle();
    const std::string whole = file.glb();
    const auto path = test_folder() / "test.glb";
    for (size_t size = 0; size < whole.size(); ++size) {
        write_file(path, whole.substr(0, size));
        ASSERT_TRUE(fails(path, "")) << size << " bytes";
    }
    write_file(path, whole);
    EXPECT_EQ(load_gltf(path).meshes.size(), 1u);
}

TEST(GltfBadFile, AnyByteOfAGlbMayBeWrong) {
    GltfBuilder file;
    const size_t node = file.triangle();
    file.json["nodes"][node]["rotation"] = {0, 0, 0, 1};
    const std::string whole = file.glb();
    const auto path = test_folder() / "test.glb";
    for (size_t i = 0; i < whole.size(); ++i) {
        for (const char value : {'\0', '\xff', '9', '"', '{'}) {
            std::string broken = whole;
            broken[i] = value;
            write_file(path, broken);
            loads(path);
        }
    }
}

TEST(GltfBadFile, DeeplyNestedJsonIsRejectedBeforeParsing) {
    for (const char* open : {"[", "{\"a\":"}) {
        std::string text = R"({"asset": {"version": "2.0"}, "extras": )";
        for (int i = 0; i < 200000; ++i) text += open;
        EXPECT_TRUE(fails(write_file(test_folder() / "test.gltf", text), "nested deeper than"));
    }
    std::string brackets(100000, '[');
    const json harmless = {{"asset", {{"version", "2.0"}, {"generator", "\"" + brackets}}}};
    EXPECT_TRUE(loads(write_file(test_folder() / "test.gltf", harmless.dump())));
}

TEST(GltfBadFile, DevicesPipesSocketsAndFoldersAreNotRead) {
    const auto folder = test_folder();
    ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
    const int listener = socket(AF_UNIX, SOCK_STREAM, 0);
    // Relative, since the path of a socket has at most 107 bytes.
    const auto before = std::filesystem::current_path();
    std::filesystem::current_path(folder);
    const sockaddr_un address{AF_UNIX, "socket"};
    ASSERT_EQ(bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    std::filesystem::current_path(before);
    for (const std::string& path : {std::string("/dev/zero"), std::string("/dev/null"),
                                    (folder / "pipe").string(), folder.string()})
        EXPECT_TRUE(fails(path, "not a regular file"));
    EXPECT_TRUE(fails((folder / "socket").string(), "cannot open"));
    close(listener);
}

TEST(GltfBadFile, NamesOfTenThousandBytesStayInOneLine) {
    const std::string name(10000, 'n');
    EXPECT_TRUE(fails(test_folder() / name, "File name too long"));
    GltfBuilder file;
    file.triangle();
    file.json["nodes"][0]["name"] = name;
    EXPECT_EQ(load_gltf(file.save()).instances.at(0).name, name);
    file.json["buffers"] = {{{"byteLength", 36}, {"uri", name}}};
    EXPECT_TRUE(fails(write_file(test_folder() / "test.gltf", file.json.dump()), "buffers[0].uri"));
}

TEST(GltfBadFile, AMillionNodesAreRead) {
    constexpr int count = SIGHTLINE_SANITIZED ? 100000 : 1000000;
    std::string text = R"({"asset":{"version":"2.0"},"nodes":[{})";
    for (int i = 1; i < count; ++i) text += ",{}";
    EXPECT_TRUE(loads(write_file(test_folder() / "test.gltf", text + "]}")));
}

TEST(GltfBadFile, FilesThatAreNotGltfAreRejected) {
    const auto path = (test_folder() / "test.gltf").string();
    for (const char* text : {"", " ", "null", "[]", "3", "{", "{}", "{\"asset\":{}}", "glTF",
                             "{\"asset\":{\"version\":2}}", "{\"asset\":{\"version\":\"1.0\"}}",
                             "{\"asset\":{\"version\":\"2.0\"}} x", "{\"a\":\"\xff\"}"}) {
        SCOPED_TRACE(text);
        EXPECT_TRUE(fails(write_file(path, text), ""));
    }
    EXPECT_TRUE(fails("/nonexistent.gltf", ""));
    EXPECT_TRUE(fails(testing::TempDir(), ""));
}

}  // namespace
}  // namespace sightline
