/** Work that is done once before the next picture, however often it was asked for. */
export class Frames {
  private readonly tasks = new Set<() => void>();
  private asked = false;

  constructor(private readonly next: (task: (now: number) => void) => void) {}

  request(task: () => void): void {
    this.tasks.add(task);
    if (this.asked) return;
    this.asked = true;
    this.next(() => this.run());
  }

  private run(): void {
    this.asked = false;
    const tasks = [...this.tasks];
    this.tasks.clear();
    for (const task of tasks) task();
  }
}
