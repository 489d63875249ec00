/** Keys that act wherever the focus is, but for where a reader writes or chooses. */

export type KeyActions = Record<string, () => void>;

const kOwnArrows = "input, select, textarea, [role=tablist] *, [role=grid]";

export function listenToKeys(actions: KeyActions, busy: () => boolean): void {
  document.addEventListener("keydown", (event) => {
    if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    if (busy() && event.key !== "?") return;
    const target = event.target instanceof Element ? event.target : document.body;
    if (target.matches("select, textarea, input[type=text]")) return;
    // A button, a box or a switch is worked with space, sliders and lists with arrows.
    if (
      event.key === " " &&
      target.matches("button, input[type=checkbox], input[type=radio], summary")
    )
      return;
    if (event.key.startsWith("Arrow") && target.matches(kOwnArrows)) return;
    if (event.key === "Enter") return;
    const name = event.shiftKey && event.key.startsWith("Arrow") ? `Shift+${event.key}` : event.key;
    const action = actions[name] ?? actions[name.toLowerCase()];
    if (action === undefined) return;
    event.preventDefault();
    action();
  });
}
