import type { Camera } from "../camera.ts";
import type { Drag } from "../gestures.ts";
import type { Point } from "../geometry.ts";
import type { Overlay } from "../overlay.ts";

/** What takes clicks, drags and keys in the map's place while it is in hand. Places of the screen. */
export interface MapTool {
  /** What is to be done next, in a line. */
  instruction(): string;
  click(at: Point, camera: Camera, byKey: boolean): void;
  doubleClick(): void;
  /** A drag that begins here is the tool's; null: the map moves. */
  grab(at: Point, turning: boolean, camera: Camera): Drag | null;
  /** Whether the key meant something to it. */
  key(event: KeyboardEvent, camera: Camera): boolean;
  /** Takes back the last point; false where there is none. */
  takeBack(): boolean;
  cursor(at: Point, camera: Camera): string;
  draw(overlay: Overlay, pointer: Point | null): void;
}

export const kCornerReach = 12;

/** Steps by keyboard: metres and radians, a tenth of them with Shift. */
export const kStep = 0.1;
export const kTurn = Math.PI / 36;
