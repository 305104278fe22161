#!/usr/bin/env bash
# Makes a seed corpus for the fuzz targets from the tests' data and the catalog of scenes.
set -euo pipefail
cd "$(dirname "$0")"
data=../../crates/rhexis-cli/tests/data
catalog=../../crates/rhexis-scene/src/catalog
mkdir -p corpus/{mesh,scene,overrides,snapshot,recording,edits}
# The first byte chooses the format, in the order of `mesh_file::EXTENSIONS`.
formats=(obj msh vtu vtk ply stl vtp off glb gltf)
for index in "${!formats[@]}"; do
    for file in "$data"/*."${formats[$index]}"; do
        [ -e "$file" ] || continue
        { printf "\\x0$index"; cat "$file"; } >"corpus/mesh/$(basename "$file")"
    done
done
printf '\x00v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf -3/1/1 -2//1 -1\n' >corpus/mesh/a.obj
printf '\x04ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n' >corpus/mesh/a.ply
printf '\x05solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n' >corpus/mesh/a.stl
printf '\x07OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n' >corpus/mesh/a.off
printf '\x01$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n$Elements\n1\n1 2 2 7 1 1 2 3\n$EndElements\n' >corpus/mesh/old.msh
printf '\x06<VTKFile type="PolyData"><PolyData><Piece NumberOfPoints="3" NumberOfPolys="1"><Points><DataArray format="ascii">0 0 0 1 0 0 0 1 0</DataArray></Points><Polys><DataArray Name="connectivity" format="ascii">0 1 2</DataArray><DataArray Name="offsets" format="ascii">3</DataArray></Polys></Piece></PolyData></VTKFile>' >corpus/mesh/a.vtp
printf '\x09{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}' >corpus/mesh/a.gltf
printf '\x00v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nf 1/1/1 2/2/1 -1/-1/-1\n' >corpus/mesh/textured.obj
for file in "$catalog"/*.toml; do
    cp "$file" corpus/scene/
done
printf '\x02run.dt=5\nbodies.0.mesh.grid.nx=3\nbodies.0.tearing={ radius = 1 }' >corpus/overrides/a
head -c 300 /dev/zero | tr '\0' '\1' >corpus/edits/ones
seq 1 200 | awk '{ printf "%c", ($1 * 37) % 120 + 1 }' >corpus/edits/mixed
# Of a torn square, without their heads.
(cd ../.. && RHEXIS_SEEDS="$PWD/tests/fuzz/corpus" cargo test --release --test hostile_snapshots -- --ignored seeds)
