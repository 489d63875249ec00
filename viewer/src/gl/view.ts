import type { Camera } from "../camera.ts";
import type { Palette } from "../colours.ts";
import type { Box } from "../geometry.ts";
import type { Program } from "./programs.ts";

/** What all layers need to draw one frame. */
export class View {
  seen: Box;

  constructor(
    private readonly gl: WebGL2RenderingContext,
    readonly camera: Camera,
    readonly palette: Palette,
    readonly pixelRatio: number,
  ) {
    this.seen = camera.seen();
  }

  use(program: Program): void {
    const { gl, camera, pixelRatio } = this;
    const scale = camera.scale * pixelRatio;
    gl.useProgram(program.program);
    gl.uniform2f(program.at("centre"), camera.x, camera.y);
    gl.uniform2f(
      program.at("turn"),
      scale * Math.cos(camera.angle),
      scale * Math.sin(camera.angle),
    );
    const halfWidth = (camera.width * pixelRatio) / 2;
    gl.uniform2f(program.at("halfSize"), halfWidth, (camera.height * pixelRatio) / 2);
    gl.uniform1f(program.at("pixelRatio"), pixelRatio);
  }
}
