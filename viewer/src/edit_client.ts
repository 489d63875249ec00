/** Asks the server to edit, and what it has: the list is the server's, and is asked for again. */
import { type EditState, isMarker, readEditState, readRefusal } from "./edits.ts";
import { onShownMap } from "./edit_toml.ts";
import type { Model } from "./model.ts";

/** What a client needs of the browser; tests bring their own. */
export interface EditSurroundings {
  fetch(
    url: string,
    init?: { method: string; headers: Record<string, string>; body: string },
  ): Promise<{ ok: boolean; status: number; text(): Promise<string> }>;
  setTimeout(task: () => void, milliseconds: number): number;
  clearTimeout(timer: number): void;
}

export type Outcome = { done: true; state: EditState } | { done: false; why: string };

/** While the map is drawn; after an answer that could not be had; after news of the run. */
const kWhileDrawn = 500;
const kAfterFailure = 2_000;
const kAfterNews = 300;
const kSilent =
  "The server does not answer. What was asked for may have been done or not: the list is asked for " +
  "again, and nothing that was set here is lost.";
const kUnreadable = "The server's answer could not be read; the list is asked for again.";

export class EditClient {
  /** What is being done, in words; empty when nothing is. */
  busy = "";
  private timer = 0;
  private due = Infinity;
  private asking = false;
  /** Grows with each request that changes something: answers from before it are old. */
  private changes = 0;

  constructor(
    private readonly model: Model,
    private readonly api: (path: string) => string,
    private readonly around: EditSurroundings,
    private readonly changed: () => void,
  ) {
    model.on(["about"], () => {
      if (this.allowed) void this.ask();
    });
    // Somebody else may have edited.
    model.on(["closures", "trajectory", "verdict"], () => {
      if (this.allowed && this.busy === "") this.askIn(kAfterNews);
    });
    model.on(["reset"], () => this.forget());
  }

  get allowed(): boolean {
    return this.model.about?.canEdit ?? false;
  }

  /** Adds edits behind those that are there; `onMap` when they are told on the map in sight. */
  add(toml: string, onMap: boolean, words: string): Promise<Outcome> {
    return this.change(words, async () => {
      await this.dropRefused();
      const text = onMap ? onShownMap(toml, this.model.edits) : toml;
      return this.request("api/edits", { toml: text });
    });
  }

  /** Takes back the last edit, and markers behind it. */
  undo(): Promise<Outcome> {
    return this.change("Undoing …", async () => {
      while (this.lastIs(isMarker)) this.take(await this.request("api/edits/undo", {}));
      if (this.model.edits?.edits.length === 0) return this.model.edits;
      return this.request("api/edits/undo", {});
    });
  }

  save(): Promise<Outcome> {
    return this.change("Saving …", async () => {
      await this.dropRefused();
      return this.request("api/edits/save", {});
    });
  }

  /** What was refused changes nothing, and would only be refused again: it goes with the next step. */
  private async dropRefused(): Promise<void> {
    while (this.lastIs((edit) => !edit.applied)) {
      this.take(await this.request("api/edits/undo", {}));
    }
  }

  private lastIs(wish: (edit: EditState["edits"][number]) => boolean): boolean {
    const last = this.model.edits?.edits.at(-1);
    return last !== undefined && wish(last);
  }

  private async change(words: string, act: () => Promise<EditState>): Promise<Outcome> {
    if (this.busy !== "") return { done: false, why: "Another edit is being done; try again." };
    this.busy = words;
    this.changes++;
    this.changed();
    try {
      const state = await act();
      this.take(state);
      return { done: true, state };
    } catch (error) {
      this.askIn(kAfterFailure);
      return { done: false, why: error instanceof Error ? error.message : String(error) };
    } finally {
      this.busy = "";
      this.changes++;
      this.changed();
    }
  }

  private async request(path: string, body: object | null): Promise<EditState> {
    const headers = { "Content-Type": "application/json" };
    const init =
      body === null ? undefined : { method: "POST", headers, body: JSON.stringify(body) };
    let answer: { ok: boolean; status: number };
    let text: string;
    try {
      const given = await this.around.fetch(this.api(path), init);
      text = await given.text();
      answer = given;
    } catch {
      throw new Error(kSilent);
    }
    if (!answer.ok) throw new Error(readRefusal(text, answer.status));
    const state = readEditState(text);
    if (state === null) throw new Error(kUnreadable);
    return state;
  }

  private take(state: EditState): void {
    this.model.edits = state;
    this.model.changed("edits");
    if (state.drawn < state.revision) this.askIn(kWhileDrawn);
  }

  /** The list as it is now; asked again where there was no answer. */
  async ask(): Promise<void> {
    if (this.asking) return;
    this.cancelTimer();
    this.asking = true;
    const { changes } = this;
    try {
      const state = await this.request("api/edits", null);
      if (changes === this.changes) this.take(state);
      else if (this.busy === "") this.askIn(kWhileDrawn);
    } catch (error) {
      // A connection that is lost is told already; the list is asked for when there is one again.
      if (this.model.connection.state === "open") {
        const why = error instanceof Error ? error.message : String(error);
        if (why !== kSilent) this.model.note(`The list of edits: ${why}`);
        this.askIn(kAfterFailure);
      }
    } finally {
      this.asking = false;
    }
  }

  private askIn(wait: number): void {
    if (this.due <= wait) return;
    this.cancelTimer();
    this.due = wait;
    this.timer = this.around.setTimeout(() => {
      this.due = Infinity;
      if (this.allowed) void this.ask();
    }, wait);
  }

  private cancelTimer(): void {
    this.around.clearTimeout(this.timer);
    this.due = Infinity;
  }

  private forget(): void {
    this.cancelTimer();
    this.changes++;
    this.model.edits = null;
    this.model.changed("edits");
  }
}
