// Corners of letters and boxes, in pixels from the upper left corner of the output.
uniform vec2 size_px;

layout(location = 0) in vec2 position_px;
layout(location = 1) in vec2 corner_uv;
layout(location = 2) in vec4 corner_color;

out vec2 uv;
out vec4 color;

void main() {
  uv = corner_uv;
  color = corner_color;
  vec2 ndc = 2.0 * position_px / size_px - 1.0;
  gl_Position = vec4(ndc.x, -ndc.y, 0.0, 1.0);
}
