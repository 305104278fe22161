// A patch of tissue, about 20 mm by 14 mm, with a smooth irregular outline; lengths in mm.
// gmsh -2 -format msh41 -o gmsh_patch.msh gmsh_patch.geo
h = 0.275;
Point(1)  = {  9.9,  0.4, 0, h};
Point(2)  = {  8.9,  3.6, 0, h};
Point(3)  = {  6.1,  5.9, 0, h};
Point(4)  = {  2.6,  6.6, 0, h};
Point(5)  = { -0.8,  7.1, 0, h};
Point(6)  = { -4.4,  6.4, 0, h};
Point(7)  = { -7.8,  4.6, 0, h};
Point(8)  = { -9.7,  1.7, 0, h};
Point(9)  = {-10.1, -1.6, 0, h};
Point(10) = { -8.2, -4.5, 0, h};
Point(11) = { -5.0, -5.7, 0, h};
Point(12) = { -1.5, -6.9, 0, h};
Point(13) = {  2.4, -6.6, 0, h};
Point(14) = {  5.7, -5.4, 0, h};
Point(15) = {  8.6, -3.1, 0, h};
Spline(1) = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 1};
Curve Loop(1) = {1};
Plane Surface(1) = {1};
Physical Surface("tissue") = {1};
Mesh.Algorithm = 6; // Frontal-Delaunay
Mesh.Smoothing = 3;
