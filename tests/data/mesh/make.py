#!/usr/bin/env python3
"""Writes the glTF files of this folder and the damaged ones of tests/bad; README.md says what they hold.

Written against the glTF 2.0 specification with Python's json and struct alone: no code is shared with the reader.
"""
import base64
import json
import pathlib
import struct

HERE = pathlib.Path(__file__).parent
BAD = HERE.parent.parent / "bad"

# The unit cube, a face a line: outward normal, four corners counter-clockwise from outside.
FACES = [
    ((0, 0, -1), [(0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0)]),
    ((0, 0, 1), [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]),
    ((0, -1, 0), [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)]),
    ((0, 1, 0), [(0, 1, 0), (0, 1, 1), (1, 1, 1), (1, 1, 0)]),
    ((-1, 0, 0), [(0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0)]),
    ((1, 0, 0), [(1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)]),
]
CORNERS_UV = [(0, 1), (1, 1), (1, 0), (0, 0)]  # from the top left, as glTF counts


def cube():
    """Normals, positions and texture places interleaved, then 16-bit indices."""
    data, indices = b"", []
    for normal, corners in FACES:
        first = len(data) // 32
        for corner, uv in zip(corners, CORNERS_UV):
            data += struct.pack("<8f", *normal, *corner, *uv)
        indices += [first, first + 1, first + 2, first, first + 2, first + 3]
    vertices = len(data)
    data += struct.pack(f"<{len(indices)}H", *indices)
    document = {
        "asset": {"version": "2.0", "generator": "make.py"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "cube", "translation": [10, 20, 30], "rotation": [0, 0, 0.5**0.5, 0.5**0.5],
                   "scale": [2, 2, 2]}],
        "materials": [{"name": "chalk"}],
        "meshes": [{"primitives": [{
            "attributes": {"NORMAL": 0, "POSITION": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0}]}],
        "accessors": [
            {"bufferView": 0, "byteOffset": 0, "componentType": 5126, "type": "VEC3", "count": 24},
            {"bufferView": 0, "byteOffset": 12, "componentType": 5126, "type": "VEC3", "count": 24,
             "min": [0, 0, 0], "max": [1, 1, 1]},
            {"bufferView": 0, "byteOffset": 24, "componentType": 5126, "type": "VEC2", "count": 24},
            {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 36},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": vertices, "byteStride": 32, "target": 34962},
            {"buffer": 0, "byteOffset": vertices, "byteLength": 2 * len(indices), "target": 34963},
        ],
        "buffers": [{"byteLength": len(data)}],
    }
    return document, data


def modes():
    """A square in the plane z = 0 as strip, fan and triangles; a mirrored child; colours and places as whole numbers."""
    square = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]
    parts = [
        struct.pack("<12f", *sum(square, ())),
        struct.pack("<12f", *sum((square[i] for i in (0, 1, 3, 2)), ())),
        bytes([0, 1, 2, 3, 3, 3]) + bytes(2),  # a strip that ends in stitches; 8-bit
        struct.pack("<6I", 0, 1, 2, 2, 1, 3),  # 32-bit
        bytes([255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 51, 51, 51, 0]),  # RGBA, 8-bit normalized
        struct.pack("<8H", 0, 65535, 65535, 65535, 0, 0, 65535, 0),  # places, 16-bit normalized
    ]
    views, data = [], b""
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(part)})
        data += part

    def accessor(view, component, kind, count, **more):
        return {"bufferView": view, "componentType": component, "type": kind, "count": count, **more}

    document = {
        "asset": {"version": "2.0"},
        "extensionsRequired": ["KHR_materials_unlit"],
        "extensionsUsed": ["KHR_materials_unlit"],
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"name": "root", "children": [1, 2, 3], "translation": [0, 0, 5]},
            {"name": "strip", "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 100, 0, 0, 1]},
            {"name": "mirrored", "mesh": 1, "scale": [-1, 1, 1]},
            {"name": "hidden", "mesh": 0, "scale": [0, 0, 0]},
        ],
        "materials": [{"name": "red"}, {}],
        "meshes": [
            {"primitives": [
                {"attributes": {"POSITION": 0, "COLOR_0": 4, "TEXCOORD_0": 5}, "indices": 2, "mode": 5, "material": 0},
                {"attributes": {"POSITION": 0}, "mode": 1},
            ]},
            {"primitives": [
                {"attributes": {"POSITION": 1}, "mode": 6, "material": 1},
                {"attributes": {"POSITION": 0}, "indices": 3},
            ]},
        ],
        "accessors": [
            accessor(0, 5126, "VEC3", 4, min=[0, 0, 0], max=[1, 1, 0]),
            accessor(1, 5126, "VEC3", 4, min=[0, 0, 0], max=[1, 1, 0]),
            accessor(2, 5121, "SCALAR", 6),
            accessor(3, 5125, "SCALAR", 6),
            accessor(4, 5121, "VEC4", 4, normalized=True),
            accessor(5, 5123, "VEC2", 4, normalized=True),
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    return document, data


def text(document):
    return json.dumps(document, separators=(",", ":")).encode()


def glb(document, data):
    head = text(document)
    head += b" " * (-len(head) % 4)
    data += bytes(-len(data) % 4)
    body = struct.pack("<I", len(head)) + b"JSON" + head + struct.pack("<I", len(data)) + b"BIN\0" + data
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def with_uri(document, uri):
    return dict(document, buffers=[dict(document["buffers"][0], uri=uri)])


def main():
    document, data = cube()
    (HERE / "cube data.bin").write_bytes(data)
    (HERE / "cube.gltf").write_bytes(text(with_uri(document, "cube%20data.bin")))
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    (HERE / "cube_base64.gltf").write_bytes(text(with_uri(document, uri)))
    (HERE / "cube.glb").write_bytes(glb(document, data))
    (HERE / "modes.glb").write_bytes(glb(*modes()))

    document, data = modes()
    (BAD / "mesh_cut.glb").write_bytes(glb(document, data)[:-30])
    document["nodes"][3]["children"] = [0]
    (BAD / "mesh_nodes_in_a_ring.glb").write_bytes(glb(document, data))
    document, data = modes()
    document["accessors"][0]["count"] = 2**62
    (BAD / "mesh_count_huge.glb").write_bytes(glb(document, data))
    document, data = modes()
    document["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 99
    (BAD / "mesh_accessor_missing.glb").write_bytes(glb(document, data))
    document, data = modes()
    document["bufferViews"][0]["byteStride"] = 4
    (BAD / "mesh_stride_short.glb").write_bytes(glb(document, data))
    (BAD / "mesh_line.obj").write_text("v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n")
    (BAD / "mesh_nan.obj").write_text("v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n")
    (BAD / "mesh_list_huge.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 4000000000\nproperty list uint int vertex_indices\nend_header\n0 0 0\n4294967295 0 0 0\n")


if __name__ == "__main__":
    main()
