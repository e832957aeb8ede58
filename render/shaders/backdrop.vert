#version 450 core
// One triangle over the whole picture, behind everything.
out vec2 place;   // -1 .. 1
void main() {
    place = vec2(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1);
    gl_Position = vec4(place, 1, 1);
}
