import { load } from "rhexis";

export const open = load;
