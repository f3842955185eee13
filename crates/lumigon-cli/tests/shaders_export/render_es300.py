"""Renders a GLSL ES 3.00 fragment shader once, without a window, and writes what it gave.

Each texture is name:width:height:kind:path, of four channels, kind f4 or f2. The picture is width x
height texels of four little-endian 32-bit floats. Prints the renderer.
"""

import argparse

import moderngl

# One triangle over everything.
VERTEX = """#version 300 es
void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
}
"""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("fragment")
    parser.add_argument("width", type=int)
    parser.add_argument("height", type=int)
    parser.add_argument("output")
    parser.add_argument("textures", nargs="*")
    arguments = parser.parse_args()

    context = moderngl.create_standalone_context(backend="egl")
    with open(arguments.fragment) as file:
        program = context.program(vertex_shader=VERTEX, fragment_shader=file.read())
    for unit, texture in enumerate(arguments.textures):
        name, width, height, kind, path = texture.split(":", 4)
        with open(path, "rb") as file:
            numbers = file.read()
        bound = context.texture((int(width), int(height)), 4, numbers, dtype=kind, alignment=1)
        bound.filter = (moderngl.NEAREST, moderngl.NEAREST)
        bound.use(unit)
        program[name] = unit
    picture = context.texture((arguments.width, arguments.height), 4, dtype="f4")
    target = context.framebuffer([picture])
    target.use()
    context.vertex_array(program, []).render(moderngl.TRIANGLES, vertices=3)
    if context.error != "GL_NO_ERROR":
        raise SystemExit(context.error)
    with open(arguments.output, "wb") as file:
        file.write(target.read(components=4, dtype="f4"))
    print(context.info["GL_RENDERER"], context.info["GL_VERSION"])


main()
