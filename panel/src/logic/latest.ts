/**
 * Asks for what somebody drags about: one question under way at a time, at most so many a second,
 * and behind it only the latest one. Answers to what is not meant any more are left out.
 */
export class Latest<Question, Answer> {
  private next: { question: Question } | null = null;
  private busy = false;
  private generation = 0;
  private last = -Infinity;

  constructor(
    private readonly options: {
      ask: (question: Question) => Promise<Answer>;
      onAnswer: (question: Question, answer: Answer) => void;
      onError: (question: Question, error: Error) => void;
      intervalMs: number;
      now?: () => number;
      setTimer?: (callback: () => void, ms: number) => void;
    },
  ) {}

  put(question: Question): void {
    ++this.generation;
    this.next = { question };
    if (!this.busy) this.go();
  }

  /** Nothing is meant any more. */
  forget(): void {
    ++this.generation;
    this.next = null;
  }

  private go(): void {
    const next = this.next;
    if (!next) return;
    const now = (this.options.now ?? (() => performance.now()))();
    const wait = this.last + this.options.intervalMs - now;
    this.busy = true;
    if (wait > 0) {
      (this.options.setTimer ?? ((f, ms) => void setTimeout(f, ms)))(() => {
        this.busy = false;
        this.go();
      }, wait);
      return;
    }
    this.next = null;
    this.last = now;
    const generation = this.generation;
    const done = (tell: () => void) => {
      this.busy = false;
      if (generation === this.generation) tell();
      this.go();
    };
    this.options.ask(next.question).then(
      (answer) => done(() => this.options.onAnswer(next.question, answer)),
      (error: Error) => done(() => this.options.onError(next.question, error)),
    );
  }
}
