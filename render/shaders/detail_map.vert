#version 450 core
// Squares of the map that hold texels of its domain.
layout(location = 0) in vec2 place;   // 0 .. 1, rows from the top
void main() { gl_Position = vec4(2.0 * place - 1.0, 0, 1); }
