import { type Box, emptyBox } from "../geometry.ts";
import type { Picture } from "../json_messages.ts";
import type { Program } from "./programs.ts";
import type { View } from "./view.ts";

/** A PNG on the map. Decoded aside; a picture that is larger than the card takes is made smaller. */
export class PictureLayer {
  readonly box: Box = emptyBox();
  failed = "";
  private texture: WebGLTexture | null = null;
  private shown: Picture | null = null;

  constructor(
    private readonly gl: WebGL2RenderingContext,
    private readonly redraw: () => void,
  ) {}

  get ready(): boolean {
    return this.texture !== null;
  }

  show(picture: Picture | null): void {
    if (picture === this.shown) return;
    this.shown = picture;
    this.gl.deleteTexture(this.texture);
    this.texture = null;
    this.failed = "";
    if (picture === null) return;
    this.decode(picture).catch((error: unknown) => {
      this.failed = error instanceof Error ? error.message : String(error);
    });
  }

  private async decode(picture: Picture): Promise<void> {
    const bytes = Uint8Array.from(atob(picture.png), (letter) => letter.charCodeAt(0));
    const blob = new Blob([bytes], { type: "image/png" });
    let bitmap = await createImageBitmap(blob);
    const { width, height } = bitmap;
    const { gl } = this;
    const most = Math.min(8192, gl.getParameter(gl.MAX_TEXTURE_SIZE) as number);
    const share = Math.min(1, most / Math.max(width, height));
    if (share < 1) {
      bitmap.close();
      bitmap = await createImageBitmap(blob, {
        resizeWidth: Math.max(1, Math.floor(width * share)),
        resizeHeight: Math.max(1, Math.floor(height * share)),
        resizeQuality: "medium",
      });
    }
    if (this.shown === picture) this.upload(bitmap);
    bitmap.close();
    Object.assign(this.box, {
      left: picture.x,
      bottom: picture.y,
      right: picture.x + width * picture.resolution,
      top: picture.y + height * picture.resolution,
    });
    this.redraw();
  }

  private upload(bitmap: ImageBitmap): void {
    const { gl } = this;
    this.texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, true);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  }

  draw(view: View, program: Program, opacity: number): void {
    if (this.texture === null || opacity <= 0) return;
    const { gl, box } = this;
    view.use(program);
    gl.uniform1f(program.at("opacity"), opacity);
    gl.uniform4f(program.at("origin"), box.left, box.bottom, 1, 0);
    gl.uniform2f(program.at("extent"), box.right - box.left, box.top - box.bottom);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  }
}
