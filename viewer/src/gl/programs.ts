/** The page's shaders. Places are metres on the map; the camera comes as a centre and a turn. */

export class GlFailure extends Error {}

export interface Program {
  program: WebGLProgram;
  at(name: string): WebGLUniformLocation | null;
}

function compile(gl: WebGL2RenderingContext, type: number, source: string): WebGLShader {
  const shader = gl.createShader(type);
  if (shader === null) throw new GlFailure("no shader");
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  return shader;
}

export function link(gl: WebGL2RenderingContext, vertex: string, fragment: string): Program {
  const program = gl.createProgram();
  if (program === null) throw new GlFailure("no program");
  gl.attachShader(program, compile(gl, gl.VERTEX_SHADER, kHead + kCamera + vertex));
  gl.attachShader(program, compile(gl, gl.FRAGMENT_SHADER, kHead + fragment));
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new GlFailure(gl.getProgramInfoLog(program) ?? "a program does not link");
  }
  const places = new Map<string, WebGLUniformLocation | null>();
  return {
    program,
    at(name) {
      let place = places.get(name);
      if (place === undefined) {
        place = gl.getUniformLocation(program, name);
        places.set(name, place);
      }
      return place;
    },
  };
}

const kHead = `#version 300 es
precision highp float;
precision highp int;
`;

const kCamera = `
uniform vec2 centre;
uniform vec2 turn;      // device pixels a metre, times cosine and sine of the view's angle
uniform vec2 halfSize;  // of the screen [device pixels]
vec2 pixelOf(vec2 place) {
  vec2 d = place - centre;
  return vec2(turn.x * d.x - turn.y * d.y, turn.y * d.x + turn.x * d.y);
}
vec4 clipOf(vec2 pixel) { return vec4(pixel / halfSize, 0.0, 1.0); }
// Of four vertices in a row.
vec2 cornerOf(int id) { return vec2(float(id & 1), float((id >> 1) & 1)); }
`;

/** A rectangle on the map with a picture: both layers of cells and pictures. */
export const kQuadVertex = `
uniform vec4 origin;    // x, y, cosine and sine of where the rectangle lies
uniform vec2 extent;    // [m]
out vec2 part;
void main() {
  vec2 corner = cornerOf(gl_VertexID);
  vec2 own = corner * extent;
  vec2 place = origin.xy + vec2(origin.z * own.x - origin.w * own.y,
                                origin.w * own.x + origin.z * own.y);
  part = corner;
  gl_Position = clipOf(pixelOf(place));
}`;

/** Cells hold 0 for unknown, else 1 more than the occupancy in percent. */
export const kCellsFragment = `
uniform highp sampler2D cells;
uniform int lod;
uniform float texelPixels;  // screen pixels a texel of that level
uniform vec3 freeColour;
uniform vec3 occupiedColour;
uniform float opacity;
in vec2 part;
out vec4 colour;
vec4 cellAt(ivec2 at, ivec2 size) {
  float value = floor(texelFetch(cells, clamp(at, ivec2(0), size - 1), lod).r * 255.0 + 0.5);
  if (value < 0.5) return vec4(0.0);
  return vec4(mix(freeColour, occupiedColour, clamp((value - 1.0) / 100.0, 0.0, 1.0)), 1.0);
}
void main() {
  ivec2 size = textureSize(cells, lod);
  vec2 at = part * vec2(size) - 0.5;
  vec2 whole = floor(at);
  // Sharp cells with smooth edges when near, a mean of neighbours when far.
  vec2 f = clamp((at - whole - 0.5) * max(texelPixels, 1.0) + 0.5, 0.0, 1.0);
  ivec2 i = ivec2(whole);
  if (f == floor(f)) {  // well within a cell, as most pixels are when near
    colour = cellAt(i + ivec2(f), size) * opacity;
    return;
  }
  vec4 low = mix(cellAt(i, size), cellAt(i + ivec2(1, 0), size), f.x);
  vec4 high = mix(cellAt(i + ivec2(0, 1), size), cellAt(i + ivec2(1, 1), size), f.x);
  colour = mix(low, high, f.y) * opacity;
}`;

export const kPictureFragment = `
uniform sampler2D picture;
uniform float opacity;
in vec2 part;
out vec4 colour;
void main() { colour = texture(picture, vec2(part.x, 1.0 - part.y)) * opacity; }`;

/** Lines of a width in pixels with round ends; the pattern runs from each line's begin. */
export const kLineVertex = `
layout(location = 0) in vec2 from;
layout(location = 1) in vec2 to;
layout(location = 2) in vec4 fromColour;
layout(location = 3) in vec4 toColour;
layout(location = 4) in vec2 style;  // width in half pixels, pattern
uniform float pixelRatio;
out vec4 shade;
out vec2 along;       // beside the line's axis, from its begin [device pixels]
flat out vec2 form;   // half width, length
flat out int pattern;
void main() {
  vec2 a = pixelOf(from);
  vec2 b = pixelOf(to);
  float length_ = distance(a, b);
  vec2 direction = length_ > 1e-4 ? (b - a) / length_ : vec2(1.0, 0.0);
  float halfWidth = style.x * pixelRatio * 0.25;
  float reach = halfWidth + 1.0;
  vec2 corner = cornerOf(gl_VertexID);
  float x = corner.x > 0.5 ? length_ + reach : -reach;
  float y = corner.y > 0.5 ? reach : -reach;
  along = vec2(x, y);
  form = vec2(halfWidth, length_);
  pattern = int(style.y + 0.5);
  float share = length_ > 1e-4 ? clamp(x / length_, 0.0, 1.0) : 0.0;
  shade = mix(fromColour, toColour, share);
  gl_Position = clipOf(a + direction * x + vec2(-direction.y, direction.x) * y);
}`;

export const kLineFragment = `
uniform float pixelRatio;
in vec4 shade;
in vec2 along;
flat in vec2 form;
flat in int pattern;
out vec4 colour;
void main() {
  float x = clamp(along.x, 0.0, form.y);
  float outside = length(vec2(along.x - x, along.y)) - form.x;
  float alpha = clamp(0.5 - outside, 0.0, 1.0);
  float p = along.x / pixelRatio;
  // Ends of a joined line are cut off, since what is drawn twice would be seen as beads.
  if (pattern == 4) alpha *= step(-0.3, along.x) * step(along.x, form.y + 0.3);
  else if (pattern == 1) alpha *= step(mod(p, 6.0), 2.5);
  else if (pattern == 2) alpha *= step(mod(p, 10.0), 6.0);
  else if (pattern == 3) { float q = mod(p, 15.0); alpha *= max(step(q, 7.0), step(abs(q - 11.0), 1.2)); }
  alpha *= shade.a;
  colour = vec4(shade.rgb * alpha, alpha);
}`;

/** Marks of a size in pixels: 0 disc, 1 ring, 2 cross, 3 diamond, 4 arrow. */
export const kMarkVertex = `
layout(location = 0) in vec3 place;   // x, y, yaw
layout(location = 1) in vec4 tint;
layout(location = 2) in vec2 style;   // size in half pixels, shape
uniform float pixelRatio;
uniform float angle;
out vec2 own;
flat out vec4 shade;
flat out int shape;
flat out float radius;
void main() {
  radius = style.x * pixelRatio * 0.25;
  own = (cornerOf(gl_VertexID) * 2.0 - 1.0) * (radius + 1.0);
  shape = int(style.y + 0.5);
  float turned = shape == 4 ? place.z + angle : 0.0;
  vec2 offset = vec2(cos(turned) * own.x - sin(turned) * own.y,
                     sin(turned) * own.x + cos(turned) * own.y);
  shade = tint;
  gl_Position = clipOf(pixelOf(place.xy) + offset);
}`;

export const kMarkFragment = `
uniform float pixelRatio;
in vec2 own;
flat in vec4 shade;
flat in int shape;
flat in float radius;
out vec4 colour;
void main() {
  float line = max(0.8 * pixelRatio, radius * 0.22);
  float outside = length(own) - radius;
  if (shape == 1) outside = abs(length(own) - radius + line) - line;
  else if (shape == 2) {
    vec2 q = abs(vec2(own.x + own.y, own.x - own.y)) * 0.7071;
    outside = max(min(q.x, q.y) - line, max(q.x, q.y) - radius);
  } else if (shape == 3) {
    float d = (abs(own.x) + abs(own.y)) - radius;
    outside = abs(d * 0.7071 + line) - line;
  } else if (shape == 4) {
    outside = max(abs(own.y) - 0.5 * (radius - own.x) * 0.7, -own.x - radius);
  }
  float alpha = clamp(0.5 - outside, 0.0, 1.0) * shade.a;
  colour = vec4(shade.rgb * alpha, alpha);
}`;
