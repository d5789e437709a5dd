#!/usr/bin/python3
"""Writes the bodies of cfd_cases/matrices/concave.toml and kinds.toml as binary STL, next to this script. Metres.

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


def polyhedron(corners, sides):
    """Convex sides, each cut into triangles around its centre, which keeps every mirror symmetry; wound outwards from the corners' mean."""

    def mean(points):
        return tuple(sum(point[k] for point in points) / len(points) for k in range(3))

    middle, triangles = mean(corners), []
    for side in sides:
        ring = [corners[index] for index in side]
        centre = mean(ring)
        u, v = ([ring[j][k] - centre[k] for k in range(3)] for j in (0, 1))
        normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        if sum(normal[k] * (centre[k] - middle[k]) for k in range(3)) < 0.0:
            ring.reverse()
        triangles += [(centre, ring[k], ring[(k + 1) % len(ring)]) for k in range(len(ring))]
    return triangles


def revolved(profile, sectors):
    """The surface of a profile (x, radius), from nose to tail, both on the axis x; between two rings quadrilaterals around their centres."""
    circle = [(math.cos(2 * math.pi * s / sectors), math.sin(2 * math.pi * s / sectors)) for s in range(sectors)]
    triangles = []
    for (x0, r0), (x1, r1) in zip(profile, profile[1:]):
        for (c, s), (cn, sn) in zip(circle, circle[1:] + circle[:1]):
            a, b, d, e = (x0, r0 * c, r0 * s), (x0, r0 * cn, r0 * sn), (x1, r1 * cn, r1 * sn), (x1, r1 * c, r1 * s)
            ring = [a, b, d, e] if r0 and r1 else [a, d, e] if r1 else [a, b, e]
            if len(ring) == 3:
                triangles.append(tuple(ring))
                continue
            centre = tuple(sum(corner[k] for corner in ring) / 4 for k in range(3))
            triangles += [(centre, ring[k], ring[(k + 1) % 4]) for k in range(4)]
    return triangles


def arc(x_centre, radius, first_deg, last_deg, steps):
    """Points (x, radius) of a circle about (x_centre, 0), angles from -x."""
    angles = [math.radians(first_deg + (last_deg - first_deg) * k / steps) for k in range(steps + 1)]
    return [(x_centre - radius * math.cos(a), 0.0 if math.sin(a) < 1e-12 else radius * math.sin(a)) for a in angles]


def crossed_plates(length, width, thickness):
    """Two plates through each other at a right angle, along x."""
    h, w = 0.5 * thickness, 0.5 * width
    rectangles = [((-h, -h), (h, h)), ((h, -h), (w, h)), ((-w, -h), (-h, h)), ((-h, h), (h, w)), ((-h, -w), (h, -h))]  # of the cross section
    triangles = []
    for (y0, z0), (y1, z1) in rectangles:
        corners = [(x, y, z) for x in (-0.5 * length, 0.5 * length) for y in (y0, y1) for z in (z0, z1)]
        sides = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]
        # What two rectangles share is inside.
        inner = {(-h, -h): {2, 3, 4, 5}, (h, -h): {2}, (-w, -h): {3}, (-h, h): {4}, (-h, -w): {5}}[(y0, z0)]
        triangles += polyhedron(corners, [side for index, side in enumerate(sides) if index not in inner])
    return triangles


half = 0.5 * math.sqrt(3)  # of an equilateral triangle of edge 1, its height
tetrahedron = [(-math.sqrt(2 / 3), 0, 0), (0, 0, 2 / 3 * half), (0, -0.5, -half / 3), (0, 0.5, -half / 3)]
axes = [tuple(sign * math.sqrt(0.5) if k == axis else 0 for k in range(3)) for axis in range(3) for sign in (-1, 1)]
frustum = [(x, y * w, z * w) for x, w in ((-0.5, 0.25), (0.5, 0.5)) for y, z in ((-1, -1), (1, -1), (1, 1), (-1, 1))]

write_stl("tetrahedron", polyhedron(tetrahedron, [(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 2, 3)]))
write_stl("octahedron", polyhedron(axes, [(x, y, z) for x in (0, 1) for y in (2, 3) for z in (4, 5)]))
write_stl("frustum", polyhedron(frustum, [(0, 1, 2, 3), (4, 5, 6, 7)] + [(k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k) for k in range(4)]))
write_stl("capsule", revolved(arc(-0.5, 0.5, 0, 90, 8) + arc(0.5, 0.5, 90, 180, 8), 32))
write_stl("hemisphere", revolved(arc(0, 0.5, 0, 90, 8) + [(0, 0)], 32))
write_stl("crossed_plates", crossed_plates(1, 1, 0.1))
write_stl("cup", hemisphere(0.5, 8, 32))
write_stl("open_box", cube_sides(block(2, 2, 2), 0.5, without=(1, 0, 0)))
write_stl("tandem_cubes-gap-0.5", cube_sides(block(2, 2, 2) | block(2, 2, 2, (3, 0, 0)), 0.5))
write_stl("tandem_cubes-gap-1.5", cube_sides(block(2, 2, 2) | block(2, 2, 2, (5, 0, 0)), 0.5))
write_stl("l_bracket", cube_sides(block(1, 4, 4) | block(4, 4, 1), 0.25))
