#!/usr/bin/python3
"""Writes the concave bodies of cfd_cases/matrices/concave.toml as binary STL, next to this script. Metres.

The triangles of every body are mirror images of each other about the planes y = 0 (and z = 0 where the shape allows), so that the
harness finds the symmetry.
"""

import math
import pathlib
import struct


def write_stl(name, triangles):
    text = bytearray(f"{name}, metres, by make_bodies.py".encode().ljust(80))
    text += struct.pack("<I", len(triangles))
    for corners in triangles:
        text += struct.pack("<12fH", 0.0, 0.0, 0.0, *(value for corner in corners for value in corner), 0)
    (pathlib.Path(__file__).parent / f"{name}.stl").write_bytes(text)


def cube_sides(cubes, size, without=None):
    """The outer squares of a union of cubes on a grid, four triangles each, wound outwards. `without`: a normal that is left open."""
    triangles = []
    for cube in sorted(cubes):
        for axis in range(3):
            for sign in (-1, 1):
                normal = tuple(sign if k == axis else 0 for k in range(3))
                if tuple(c + n for c, n in zip(cube, normal)) in cubes or normal == without:
                    continue
                u, v = (axis + 1) % 3, (axis + 2) % 3
                corners = []
                for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    corner = list(cube)
                    corner[axis] += sign > 0
                    corner[u] += du
                    corner[v] += dv
                    corners.append(tuple(size * value for value in corner))
                if sign < 0:
                    corners.reverse()
                centre = tuple(sum(corner[k] for corner in corners) / 4 for k in range(3))
                triangles += [(centre, corners[k], corners[(k + 1) % 4]) for k in range(4)]
    return triangles


def block(length, width, height, at=(0, 0, 0)):
    return {(at[0] + i, at[1] + j, at[2] + k) for i in range(length) for j in range(width) for k in range(height)}


def hemisphere(radius, rings, sectors):
    """A shell without thickness, its opening towards +x, wound with the normal on the convex side."""

    def point(ring, sector):
        polar, turn = 0.5 * math.pi * ring / rings, 2.0 * math.pi * (sector % sectors) / sectors
        return (-radius * math.cos(polar), radius * math.sin(polar) * math.cos(turn), radius * math.sin(polar) * math.sin(turn))

    triangles = []
    for sector in range(sectors):
        triangles.append((point(0, 0), point(1, sector + 1), point(1, sector)))
        for ring in range(1, rings):
            a, b = point(ring, sector), point(ring, sector + 1)
            d, c = point(ring + 1, sector), point(ring + 1, sector + 1)
            # The diagonal changes with the quadrant, which makes each the mirror image of its neighbour.
            triangles += [(a, b, c), (a, c, d)] if (4 * sector // sectors) % 2 == 0 else [(a, b, d), (b, c, d)]
    return triangles


write_stl("cup", hemisphere(0.5, 8, 32))
write_stl("open_box", cube_sides(block(2, 2, 2), 0.5, without=(1, 0, 0)))
write_stl("tandem_cubes-gap-0.5", cube_sides(block(2, 2, 2) | block(2, 2, 2, (3, 0, 0)), 0.5))
write_stl("tandem_cubes-gap-1.5", cube_sides(block(2, 2, 2) | block(2, 2, 2, (5, 0, 0)), 0.5))
write_stl("l_bracket", cube_sides(block(1, 4, 4) | block(4, 4, 1), 0.25))
