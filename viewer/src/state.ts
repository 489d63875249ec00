/** What tests, and the curious in a console, see of the page: `loopstone.state`. */
import type { App } from "./app.ts";
import type { ClosureDetail } from "./ui/closure_detail.ts";
import type { Tabs } from "./ui/tabs.ts";

export function stateOf(app: App, detail: ClosureDetail, tabs: Tabs) {
  const { model, map, settings } = app;
  const { x, y, scale, angle, width, height } = map.camera;
  return {
    connection: model.connection.state,
    about: model.about,
    theme: app.theme,
    tab: tabs.current,
    camera: { x, y, scale, angle, width, height },
    mode: map.mode,
    layers: { ...settings.layers },
    opacity: { ...settings.opacity },
    closureStates: { ...settings.closures },
    pathColour: settings.pathColour,
    drawn: map.scene.counts(),
    frames: map.frames,
    frameTime: map.frameTime,
    selected: app.selected,
    evidence: detail.evidence?.id ?? null,
    asMeasured: detail.asMeasured,
    robot: model.robot,
    scanPoints: model.scanPoints,
    nodes: model.track.length,
    closures: model.closures.length,
    submaps: model.submaps.length,
    particles: model.particles.length / 3,
    verdict: model.verdict?.verdict ?? null,
    warnings: model.warnings.length,
    notes: [...model.notes],
    damaged: model.damaged,
    received: model.received,
    pictures: { quality: map.scene.quality.ready, texture: map.scene.texture.ready },
    figures: [...model.series.keys()],
    status: model.status?.status ?? null,
    playback: {
      canSeek: model.canSeek,
      status: model.playback,
      time: model.time,
      start: model.start,
      end: model.end,
      speed: model.speed,
    },
    edits: model.edits,
    edit: {
      tool: app.editor.kind,
      busy: app.editor.client.busy,
      message: { ...app.editor.message },
      problem: app.editor.tool?.problem() ?? null,
      toml:
        app.editor.tool !== null && app.editor.tool.problem() === null
          ? app.editor.tool.toml()
          : "",
    },
    measure: {
      active: map.measure.active,
      points: [...map.measure.points],
      total: map.measure.total,
    },
  };
}

export type PageState = ReturnType<typeof stateOf>;

export interface Exposed {
  readonly state: PageState;
  measureFrames(count: number, moving?: boolean): number[];
  toScreen(x: number, y: number): { x: number; y: number };
  node(i: number): { x: number; y: number } | null;
}

export function exposeState(app: App, detail: ClosureDetail, tabs: Tabs): void {
  const exposed: Exposed = {
    get state() {
      return stateOf(app, detail, tabs);
    },
    /** Times of whole pictures [ms]; with `moving`, all buffers are filled anew for each. */
    measureFrames(count, refill = false) {
      return app.map.measureFrames(count, () => (refill ? app.map.scene.refill() : undefined));
    },
    toScreen: (x, y) => app.map.camera.toScreen({ x, y }),
    node: (i) => app.model.track.pose(i),
  };
  Object.assign(window, { loopstone: exposed });
}
